// The transform of lossless coding: butterfly prediction, no update, on integers. What it computes is the same on every
// machine, bit for bit (FORMAT.md 5.1).
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "codec/mesh/semi_regular.h"

namespace mvw {

using IntegerPoint = std::array<std::int32_t, 3>;

/// Both in hierarchical order, V(levels): details are what the prediction from the level below misses, the base
/// vertices stay. Coordinates within 2^25. Returns in place. creases: as in SemiRegularMesh. O(V).
void analyze_integers(const BaseMesh& base, unsigned levels, std::span<const std::uint8_t> creases,
                      std::span<IntegerPoint> points);
/// Inverts analyze_integers(). Any input gives some output: sums wrap.
void synthesize_integers(const BaseMesh& base, unsigned levels, std::span<const std::uint8_t> creases,
                         std::span<IntegerPoint> points);

}  // namespace mvw
