// A window that shows a model as it refines: GLFW, OpenGL 3.3, Dear ImGui.
#pragma once
#include <limits>
#include <string>

#include "client/client.h"
#include "codec/result.h"

namespace mvw::client {

struct WindowOptions {
    std::string place;  // a .mvw file or a URL
    StreamOptions stream;
    int width = 1280, height = 800;
    unsigned level = 255, layer = 255;
    double bytes_per_second = std::numeric_limits<double>::infinity();  // of the link, at first
    bool wireframe = false, flat = false, z_up = false;
    double yaw = 30, pitch = 15;
    std::string screenshot;  // PNG of the whole window once everything is there; then it closes
};

/// How the frames of a window went.
struct WindowSummary {
    std::uint64_t frames = 0;
    double longest_wait = 0;  // seconds that one frame spent outside drawing: never on the network
};

/// Returns when the window is closed. Io where no display or OpenGL 3.3 can be had, where the model never came and
/// a screenshot was asked for, or the file cannot be written.
Result<WindowSummary> run_window(const WindowOptions& options);

}  // namespace mvw::client
