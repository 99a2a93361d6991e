// Colours as the codec sees them: Y, Co, Cg of sRGB values in [0, 1] (Malvar, Sullivan, YCoCg-R, 2003; the plain,
// unrounded form), which are nearly uncorrelated on photographs.
#pragma once
#include <algorithm>

#include "codec/mesh/mesh.h"

namespace mvw {

inline Vec3f to_ycocg(const Rgba8& c) {
    const float r = static_cast<float>(c.r) / 255, g = static_cast<float>(c.g) / 255, b = static_cast<float>(c.b) / 255;
    return {(r + 2 * g + b) / 4, (r - b) / 2, (2 * g - r - b) / 4};
}

/// alpha: in [0, 1]. What lies outside is clamped.
inline Rgba8 to_rgba(const Vec3f& c, float alpha) {
    const auto byte = [](float x) { return static_cast<std::uint8_t>(std::clamp(x * 255 + 0.5f, 0.0f, 255.0f)); };
    const float below = c.x - c.z;
    return {byte(below + c.y), byte(c.x + c.z), byte(below - c.y), byte(alpha)};
}

}  // namespace mvw
