// Which tiles a camera sees, and how large: what a stream is asked for first.
#pragma once
#include "client/viewer/window/live_model.h"
#include "client/viewer/window/live_renderer.h"

namespace mvw::client {

/// Tiles in view get priority 2 to 8 by their size on screen, all others stay at the request's 1: they come last, and
/// come. Empty where there is nothing to choose (at most one tile).
std::vector<protocol::TilePriority> visible_tiles(const std::vector<TilePlace>& tiles, const Turntable& camera);

}  // namespace mvw::client
