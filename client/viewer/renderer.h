// Draws meshes and lines with OpenGL 3.3 into whatever framebuffer is bound. The caller owns the context.
#pragma once
#include <vector>

#include "client/viewer/camera.h"
#include "client/viewer/sides.h"
#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

struct RenderOptions {
    unsigned width = 0, height = 0;  // pixels of the framebuffer
    float line_width = 1;            // pixels
    bool wireframe = false;
    bool flat = false;
    Backs backs = Backs::StepBehind;
};

/// Background, mesh, lines: one whole frame. `lines` are polylines in model units. Io where the driver refuses the
/// shaders or runs out of memory.
Result<void> render_frame(const Mesh& mesh, const std::vector<std::vector<Vec3>>& lines, const Camera& camera,
                          const RenderOptions& options);

}  // namespace mvw
