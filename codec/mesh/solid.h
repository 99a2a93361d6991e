// Which surfaces can be looked at from one side only.
#pragma once
#include <span>

#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Whether a surface bounds solids: it has faces, no boundary, and each component encloses a volume that lies behind
/// its faces (so the walls of a cavity, whose volume is another component's hole, do not). From outside, whoever looks
/// along a ray that meets a back then meets a front, too, and the nearest front is no far wall's. positions: at least
/// those of the base's vertices. Time grows with V + F, but for the logarithm of disjoint sets.
bool bounds_solids(const BaseMesh& base, std::span<const Vec3> positions);
/// Likewise; false where more than two faces share an edge, or two run along it in one direction. Sorts the edges at
/// each vertex.
bool bounds_solids(const Mesh& mesh);

}  // namespace mvw
