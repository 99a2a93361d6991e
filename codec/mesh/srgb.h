// Between sRGB fractions and linear ones (IEC 61966-2-1).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "codec/mesh/mesh.h"

namespace mvw {

inline double to_srgb(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}
inline double to_linear(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
/// The nearest of 256 steps; what lies outside is clamped, what is no number 0.
inline std::uint8_t to_byte(double fraction) {
    return static_cast<std::uint8_t>(std::lround(fraction > 0 ? 255 * std::min(fraction, 1.0) : 0.0));
}

/// Red, green, blue (linear) and alpha, in [0, 1].
inline std::array<double, 4> to_linear(const Rgba8& c) {
    return {to_linear(c.r / 255.0), to_linear(c.g / 255.0), to_linear(c.b / 255.0), c.a / 255.0};
}
inline Rgba8 to_srgb(const std::array<double, 4>& linear) {
    return {to_byte(to_srgb(linear[0])), to_byte(to_srgb(linear[1])), to_byte(to_srgb(linear[2])), to_byte(linear[3])};
}

}  // namespace mvw
