// Draws a Drawable with OpenGL 3.3 into whatever framebuffer is bound, from buffers that stay on the card.
#pragma once
#include <array>
#include <cstdint>

#include "client/drawable.h"
#include "codec/result.h"

namespace mvw::client {

/// How a window looks at a model: a turntable.
struct Turntable {
    double yaw = 30, pitch = 15;  // degrees, as in camera.h
    double zoom = 1;              // 1: all of the model fits
    double pan_x = 0, pan_y = 0;  // of the picture's height, at zoom 1
    bool z_up = false;
    Vec3f middle;                                // relative to the drawable's origin
    float radius = 1;                            // of a sphere that holds the model
    double eye_to_middle = 1;                    // set by aim()
    std::array<float, 16> view{}, projection{};  // column-major; set by aim()

    /// Makes the middle and radius those of a drawable's box.
    void fit(const Drawable& drawable);
    /// Sets the matrices for a picture of that width / height, the model in the middle of what `covered` of the width,
    /// at the left, leaves.
    void aim(double aspect, double covered = 0);
};

struct LiveLook {
    bool flat = false, edges = false, base_edges = false, colors = true;
};

class LiveRenderer {
 public:
    LiveRenderer() = default;
    ~LiveRenderer();
    LiveRenderer(const LiveRenderer&) = delete;
    LiveRenderer& operator=(const LiveRenderer&) = delete;

    /// Needs a current context. Io where the driver refuses the shaders.
    Result<void> start();
    /// To the card.
    void upload(const Drawable& drawable);
    void draw(const Turntable& camera, const LiveLook& look) const;

 private:
    void draw_elements(unsigned mode, unsigned which) const;

    unsigned surface_ = 0, lines_ = 0, background_ = 0, array_ = 0, empty_ = 0;
    std::array<unsigned, 6> buffers_{};  // positions, normals, colours, triangles, edges, base edges
    std::array<int, 3> counts_{};        // of the last three
    bool colored_ = false, solid_ = false;
};

}  // namespace mvw::client
