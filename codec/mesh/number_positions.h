// Vertices at equal positions: STL files have one for each corner of a face.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// V numbers, from 0 on in order of each position's first vertex: equal where the coordinates are, -0 being 0. Values
/// that are no numbers equal nothing. O(V).
std::vector<std::uint32_t> number_positions(std::span<const Vec3> positions);

}  // namespace mvw
