// The window's controls and figures (Dear ImGui).
#pragma once
#include <array>
#include <string>
#include <vector>

#include "client/viewer/window/live_model.h"
#include "client/viewer/window/live_renderer.h"

namespace mvw::client {

/// Pixels at the window's left that the panel takes.
inline constexpr double kPanelWidth = 304;

/// What the window shows and what people chose.
struct Panel {
    LiveLook look;
    int level = 255;
    Turntable camera;
    // Figures of the newest frame.
    DecodeState state;
    std::size_t vertices = 0, triangles = 0;
    unsigned drawn_level = 0, levels = 0;
    std::uint64_t file_bytes = 0;
    double draw_seconds = 0, frame_rate = 0;
    bool has_colors = false, ended = false;
    std::string message;
    std::vector<std::array<float, 2>> curve;  // bytes, decibels of what has come

    /// Takes over the figures of a frame.
    void note(const LiveFrame& frame);
    [[nodiscard]] DrawableOptions drawable_options() const;
};

/// Draws the panel; true where the next drawable must hold something else.
bool draw_panel(Panel& panel);

}  // namespace mvw::client
