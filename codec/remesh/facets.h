// Components of few flat faces, which no smaller base serves: they are their own base.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Most faces of a component that is its own base: no more than the bases of remeshes have.
inline constexpr std::uint32_t kMostFacets = 1500;

/// Flags (one for each of `components`) of those among the wanted ones that may be their own bases: of few faces, too,
/// all together, and without many vertices of a single face, whose details would not be zero; where such ears are
/// allowed, these too while there is room. mesh: clean. component_of_face (F). O(F).
std::vector<std::uint8_t> choose_facets(const Mesh& mesh, const std::vector<std::uint32_t>& component_of_face,
                                        std::size_t components, bool allow_ears,
                                        const std::function<bool(std::uint32_t)>& wanted);

/// Splits edges opposite vertices of a single face, which have three edges then, and the longest edges until none is
/// longer than `longest` or there are a quarter more faces (and 64): images on large faces have more vertices to show
/// on. The surface stays; its vertices come first.
void split_large_faces(Mesh& mesh, double longest);

/// mesh: clean, F faces. A semi-regular mesh of one level over the same F faces, in their order; every edge is a
/// crease. Prediction along and beside creases that end at corners is by midpoints, so where each vertex has three
/// edges or more all details are zero: the surface is the input's. Vertices, colours and materials are the input's; new
/// vertices lie at the middles of edges. O(F).
SemiRegularMesh facets_of(const Mesh& mesh);

}  // namespace mvw
