// Which chunks a camera needs: tiles by the error that is left of them on the screen, and the level at which it no
// longer shows.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/decoder.h"
#include "server/protocol/messages.h"

namespace mvw::client {

/// A camera as far as the choice needs it. The model is relative to its header's `center`, as in drawable.h.
struct View {
    std::array<float, 16> from_model{};  // column-major and rigid, to a camera that looks along -z
    float scale_x = 1, scale_y = 1;      // 1 / tangent of half the angle of view, across and up
    float nearest = 0.01f;               // nothing counts as nearer than this, model units; > 0
    unsigned height = 1080;              // of the picture, pixels
    float pixel_error = 0;               // levels that would mend less are left out; 0: none is
    bool outside = true;                 // tiles out of view are wanted as well, after all others
    friend bool operator==(const View&, const View&) = default;
};

/// Where one tile of one part lies, and how coarse its level 0 is.
struct TilePlace {
    std::uint16_t part = 0, tile = 0;
    Vec3f middle;
    float radius = 0;  // of a sphere that holds its level 0
    float edge = 0;    // longest of level 0
    std::uint8_t levels = 0;
};

/// Of all parts whose base is there.
std::vector<TilePlace> place_tiles(const Decoder& decoder);

/// The error of level l on the screen is taken to be an eighth of its edges at the tile's nearest point: the height of
/// an arc of 60 degrees above its chord. Tiles in view get priorities from 2 up, one more for each doubling of the
/// error of level 0; the others, if they are wanted at all, the request's own 1. Empty where there is nothing to choose
/// (one tile and all its levels). At most as many as a server takes: the largest errors.
std::vector<protocol::TilePriority> choose_tiles(std::span<const TilePlace> tiles, const View& view);

}  // namespace mvw::client
