#include "client/viewer/window/visible_tiles.h"

#include <algorithm>
#include <cmath>

namespace mvw::client {

std::vector<protocol::TilePriority> visible_tiles(const std::vector<TilePlace>& tiles, const Turntable& camera) {
    std::vector<protocol::TilePriority> seen;
    if (tiles.size() < 2) return seen;
    const auto& m = camera.view;
    for (const TilePlace& tile : tiles) {
        const Vec3f c = tile.middle;
        const float x = m[0] * c.x + m[4] * c.y + m[8] * c.z + m[12], y = m[1] * c.x + m[5] * c.y + m[9] * c.z + m[13];
        const float depth = -(m[2] * c.x + m[6] * c.y + m[10] * c.z + m[14]);
        if (depth + tile.radius <= 0) continue;  // behind the eye
        const float near = std::max(depth - tile.radius, 0.05f * camera.radius);
        const float half_width = std::max(depth, near) / camera.projection[0];
        const float half_height = std::max(depth, near) / camera.projection[5];
        if (std::abs(x) > half_width + tile.radius || std::abs(y) > half_height + tile.radius) continue;
        const float size = tile.radius * camera.projection[5] / near;  // of half the picture's height
        const int priority = std::clamp(static_cast<int>(std::lround(6 + 2 * std::log2(std::max(size, 1e-3f)))), 2, 8);
        seen.push_back({tile.part, tile.tile, static_cast<std::uint8_t>(priority)});
    }
    return seen;
}

}  // namespace mvw::client
