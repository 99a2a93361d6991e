// Pictures of meshes without a window (EGL, surfaceless): what `mvw view --screenshot` and every report draws with.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

/// 8-bit RGB rows, top row first.
struct Image {
    unsigned width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

struct PictureOptions {
    unsigned width = 1024, height = 768;
    bool wireframe = false;
    bool flat = false;            // facet normals instead of smooth ones
    double yaw = 30, pitch = 15;  // degrees around the model; it always fills the picture
    Box frame;                    // what to fit into the picture; empty: the mesh's own box
};

/// Draws one mesh with a headless OpenGL context. Back faces are tinted, so that flipped triangles show. Io where no
/// OpenGL can be had (the message names the missing package).
Result<Image> draw_picture(const Mesh& mesh, const PictureOptions& options);

/// Writes a PNG beside its final name, then renames.
Result<void> write_png(const std::string& path, const Image& image);

}  // namespace mvw
