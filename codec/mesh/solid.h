// Which surfaces can be looked at from one side only.
#pragma once
#include <span>

#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Whether a surface bounds solids: it has faces, no boundary, and each component encloses a volume that lies behind
/// its faces. From outside, every ray that meets a back then meets a front, too. positions: at least those of the
/// base's vertices. O(V + F) but for the logarithm of disjoint sets.
bool bounds_solids(const BaseMesh& base, std::span<const Vec3> positions);
/// Likewise; false for a mesh that is no oriented manifold.
bool bounds_solids(const Mesh& mesh);

}  // namespace mvw
