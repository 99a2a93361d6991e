// Where along boundaries and features the vertices of a remesh are laid.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"
#include "codec/remesh/self_parameterization.h"

namespace mvw {

/// Moves grid points along the base edges that follow a boundary or a crease: even steps of the parameterisation cut
/// off bends that are shorter than a step, as rounded corners of CAD models are. Where they leave an edge by more than
/// kMostCut, half of its points are laid by length and half by how much the line turns.
///
/// mesh      the input, in a box of unit diagonal
/// part      base, levels and creases are read
/// face_ids  of each base face, its number in parameterization.base()
/// points    V(levels), in and out: as grid_points() makes them, on the base
void space_lines(const Mesh& mesh, const SelfParameterization& parameterization, const SemiRegularMesh& part,
                 const std::vector<std::uint32_t>& face_ids, unsigned threads, std::vector<FacePoint>& points);

}  // namespace mvw
