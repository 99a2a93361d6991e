// Between sRGB fractions and linear ones (IEC 61966-2-1).
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace mvw {

inline double to_srgb(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}
inline double to_linear(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
/// The nearest of 256 steps; what lies outside is clamped.
inline std::uint8_t to_byte(double fraction) {
    return static_cast<std::uint8_t>(std::lround(255 * std::min(std::max(fraction, 0.0), 1.0)));
}

}  // namespace mvw
