// Irons out what is still folded when a remesh lies where it shall: edges whose two triangles fold back on each other,
// and triangles without area.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// Draws vertices at such edges towards their neighbours' mean as long as that leaves fewer of them, or lesser ones;
/// all else stays, and so do vertices flagged `fixed` (V). None goes farther than half the length of its edges. Returns
/// how many have moved. O(F), and O(1) for each folded edge and round.
std::size_t iron(const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
                 std::vector<Vec3>& positions);

}  // namespace mvw
