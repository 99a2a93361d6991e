// Chooses the lattice of a base.
#pragma once
#include <span>
#include <vector>

#include "codec/mesh/lattice.h"
#include "codec/mesh/mesh.h"

namespace mvw {

/// One of cells of 2^-bits or up to a quarter more, on which rounding moves the surface least along its normals: planes
/// across an axis, of which models of machined parts and buildings have a few, come to lie on it. The plain one where
/// none is so much better that saying it is worth its bytes, as on scans. positions: of `faces`, in coded units.
/// O(V log V).
Lattice fit_lattice(std::span<const Vec3> positions, const std::vector<Face>& faces, unsigned bits);

/// Likewise, for vertices that come to finer lattices one by one: along an axis that gains little by fitting the cells
/// are those of Lattice::nested(), where each finer lattice asks for just one bit more.
Lattice fit_nested_lattice(std::span<const Vec3> positions, const std::vector<Face>& faces, unsigned bits);

/// The points that are nearest to the positions.
Rounded round_to(const Lattice& lattice, std::span<const Vec3> positions);

std::vector<Vec3> points_of(const Rounded& rounded);

/// RMS over the surface of how far it moves along its normals where its vertices are rounded: what rounding adds to a
/// surface's error, squared and summed, while edges are longer than cells. Coded units. O(F).
double moved_by_rounding(const Rounded& rounded, std::span<const Vec3> positions, const std::vector<Face>& faces);

/// The points of fit_lattice()'s that are nearest to the positions.
Rounded round_to_lattice(std::span<const Vec3> positions, const std::vector<Face>& faces, unsigned bits);

}  // namespace mvw
