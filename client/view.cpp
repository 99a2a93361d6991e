#include "client/view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "codec/tiles.h"

namespace mvw::client {
namespace {

constexpr float kArcHeight = 1.0f / 8;  // of an arc of 60 degrees, as a share of its chord
constexpr int kFirstPriority = 2, kMostDoublings = 12;

struct Bounds {
    Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    double edge = 0;

    void add(const Vec3& p) {
        for (std::size_t i = 0; i < 3; ++i) {
            low[i] = std::min(low[i], p[i]);
            high[i] = std::max(high[i], p[i]);
        }
    }
};

TilePlace place_of(const Bounds& bounds, const Vec3& origin) {
    TilePlace place;
    place.middle = to_float((bounds.low + bounds.high) / 2.0 - origin);
    place.radius = static_cast<float>(length(bounds.high - bounds.low) / 2);
    place.edge = static_cast<float>(bounds.edge);
    return place;
}

// Pixels that a model unit takes at the tile's nearest point; none where the tile is out of view.
std::optional<float> pixels_per_unit(const TilePlace& tile, const View& view) {
    const auto& m = view.from_model;
    const Vec3f& c = tile.middle;
    const float x = m[0] * c.x + m[4] * c.y + m[8] * c.z + m[12], y = m[1] * c.x + m[5] * c.y + m[9] * c.z + m[13];
    const float depth = -(m[2] * c.x + m[6] * c.y + m[10] * c.z + m[14]);
    if (depth + tile.radius <= 0) return std::nullopt;  // behind the eye
    const float near = std::max(depth - tile.radius, view.nearest), middle = std::max(depth, near);
    // To the sides of the view's pyramid, whose planes lean outwards.
    const auto beyond = [&](float at, float scale) {
        return (std::abs(at) * scale - middle) / std::sqrt(1 + scale * scale) > tile.radius;
    };
    if (beyond(x, view.scale_x) || beyond(y, view.scale_y)) return std::nullopt;
    return view.scale_y * static_cast<float>(view.height) / (2 * near);
}

// How often `error` is to be halved until it is at most `good`, as far as `most`.
int halvings_to(float good, float error, int most) {
    int halvings = 0;
    for (; error > good && halvings < most; error /= 2) ++halvings;
    return halvings;
}

// The coarsest level whose error on the screen is at most the view's.
std::uint8_t level_for(float error, const TilePlace& tile, const View& view) {
    if (view.pixel_error <= 0) return 255;
    return static_cast<std::uint8_t>(halvings_to(view.pixel_error, error, tile.levels));
}

// At most so many, the highest priorities; the order stays.
void keep_most_urgent(std::vector<protocol::TilePriority>& tiles, std::size_t most) {
    std::array<std::size_t, kFirstPriority + kMostDoublings + 1> count{};
    for (const protocol::TilePriority& t : tiles) ++count[t.priority];
    std::size_t lowest = count.size() - 1, room = most;
    while (lowest > 0 && count[lowest] <= room) room -= count[lowest--];
    std::erase_if(tiles, [&](const protocol::TilePriority& t) {
        return t.priority < lowest || (t.priority == lowest && (room == 0 || room-- == 0));
    });
}

}  // namespace

std::vector<TilePlace> place_tiles(const Decoder& decoder) {
    std::vector<TilePlace> places;
    const Result<Mesh> bases = decoder.mesh(0);
    if (!bases.ok()) return places;
    const FileHeader& header = *decoder.header();
    const Vec3 origin{header.center[0], header.center[1], header.center[2]};
    std::size_t first_face = 0;
    for (std::size_t part = 0; part < header.parts.size(); ++part) {
        if (!decoder.shows(part, 0)) continue;
        if (part >= header.main_parts()) return {};  // a preview: tiles are of what follows it
        const BaseMesh* base = decoder.base(part);
        if (base->vertex_count() < header.parts[part].base_vertices) return {};  // splits will change its faces
        const std::vector<std::uint16_t> tile_of = tile_of_faces(*base, header.parts[part].tiles);
        std::vector<Bounds> bounds(header.parts[part].tiles);
        for (std::size_t f = 0; f < tile_of.size(); ++f) {
            Bounds& b = bounds[tile_of[f]];
            const auto& face = bases->faces[first_face + f];
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 &p = bases->positions[face[k]], &q = bases->positions[face[(k + 1) % 3]];
                b.add(p);
                b.edge = std::max(b.edge, length(q - p));
            }
        }
        for (std::size_t tile = 0; tile < bounds.size(); ++tile) {
            TilePlace place = place_of(bounds[tile], origin);
            place.part = static_cast<std::uint16_t>(part);
            place.tile = static_cast<std::uint16_t>(tile);
            place.levels = header.parts[part].levels;
            places.push_back(place);
        }
        first_face += tile_of.size();
    }
    return places;
}

std::vector<protocol::TilePriority> choose_tiles(std::span<const TilePlace> tiles, const View& view) {
    std::vector<protocol::TilePriority> chosen;
    if (tiles.size() < 2 && view.pixel_error <= 0) return chosen;
    for (const TilePlace& tile : tiles) {
        const std::optional<float> scale = pixels_per_unit(tile, view);
        if (!scale) continue;
        const float error = std::max(kArcHeight * tile.edge * *scale, 1.0f);
        const int doublings = halvings_to(std::numbers::sqrt2_v<float>, error, kMostDoublings);
        chosen.push_back({tile.part, tile.tile, static_cast<std::uint8_t>(kFirstPriority + doublings),
                          level_for(error, tile, view)});
    }
    keep_most_urgent(chosen, protocol::MessageLimits{}.max_tiles);
    return chosen;
}

}  // namespace mvw::client
