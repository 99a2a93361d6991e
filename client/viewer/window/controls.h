// The window's controls and figures (Dear ImGui).
#pragma once
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "client/viewer/window/live_model.h"
#include "client/viewer/window/live_renderer.h"

namespace mvw::client {

/// Pixels at the window's left that the panel takes.
inline constexpr double kPanelWidth = 318;

/// What the window shows and what people chose.
struct Panel {
    LiveLook look;
    int level = 255, layer = 255;
    std::optional<float> bytes;  // of the file's beginning, where people went back to it
    std::size_t speed = 0;       // of kSpeeds
    Turntable camera;
    // Figures of the newest frame.
    DecodeState state;
    std::size_t vertices = 0, triangles = 0;
    unsigned drawn_level = 0, levels = 0;
    std::uint64_t file_bytes = 0;
    unsigned layers = 0;
    double arrived = 0, draw_seconds = 0, decode_seconds = 0, frame_rate = 0;
    bool has_colors = false, ended = false;
    std::string message;
    std::vector<std::array<float, 2>> curve;  // bytes, decibels of what has come

    /// Takes over the figures of a frame.
    void note(const LiveFrame& frame);
    [[nodiscard]] LiveChoice choice() const;
};

/// Speeds of the link that can be chosen.
struct Speed {
    const char* name;
    double bytes_per_second;
};
inline constexpr std::array<Speed, 4> kSpeeds{
    {{"Full", std::numeric_limits<double>::infinity()}, {"10 M", 1.25e6}, {"1 Mbit/s", 1.25e5}, {"128 k", 1.6e4}}};

/// What people did in the panel.
struct PanelEvents {
    bool choice = false;  // the next drawable must hold something else
    bool speed = false, again = false;
};
PanelEvents draw_panel(Panel& panel);

}  // namespace mvw::client
