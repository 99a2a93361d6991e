// Binary range coder over 32 bits with 16-bit probabilities: what both directions share. After G. N. N. Martin, Range
// encoding (1979), with the carry propagation that LZMA made common. Integers only.
#pragma once
#include <cstdint>

namespace mvw {

/// Probabilities are of a 1, in units of 2^-16, within [kMinProbability, 65536 - kMinProbability].
inline constexpr unsigned kProbabilityBits = 16;
inline constexpr std::uint32_t kMinProbability = 16;
/// The range is kept at or above this by shifting bytes out.
inline constexpr std::uint32_t kMinRange = 1u << 24;

/// Width of the part of the range that stands for a 1: the lower part.
constexpr std::uint32_t share_of_one(std::uint32_t range, std::uint32_t probability) {
    return static_cast<std::uint32_t>((std::uint64_t{range} * probability) >> kProbabilityBits);
}

}  // namespace mvw
