#include "client/viewer/picture.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "client/viewer/headless_gl.h"
#include "client/viewer/renderer.h"
#include "codec/mesh/semi_regular.h"
#include "codec/mesh/solid.h"

namespace mvw {
namespace {

constexpr unsigned kOversampling = 2;  // rows and columns drawn for one of the picture, on top of 4 samples each
constexpr GLsizei kSamples = 4;

/// A framebuffer to draw into and read back.
class Canvas {
 public:
    Canvas(unsigned width, unsigned height, GLsizei samples) {
        const auto w = static_cast<GLsizei>(width), h = static_cast<GLsizei>(height);
        glGenFramebuffers(1, &framebuffer_);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
        glGenRenderbuffers(2, buffers_.data());
        glBindRenderbuffer(GL_RENDERBUFFER, buffers_[0]);
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_SRGB8_ALPHA8, w, h);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers_[0]);
        glBindRenderbuffer(GL_RENDERBUFFER, buffers_[1]);
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT32F, w, h);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffers_[1]);
    }
    ~Canvas() {
        glDeleteRenderbuffers(2, buffers_.data());
        glDeleteFramebuffers(1, &framebuffer_);
    }
    Canvas(const Canvas&) = delete;
    Canvas& operator=(const Canvas&) = delete;

    [[nodiscard]] GLuint id() const { return framebuffer_; }
    [[nodiscard]] bool complete() const {
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
        return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    }

 private:
    GLuint framebuffer_ = 0;
    std::array<GLuint, 2> buffers_{};
};

/// Resolves the samples of `from` through `to` and reads the pixels, bottom row first, 4 bytes each.
std::vector<std::uint8_t> read_back(const Canvas& from, const Canvas& to, unsigned width, unsigned height) {
    const auto w = static_cast<GLint>(width), h = static_cast<GLint>(height);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, from.id());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to.id());
    glBlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, to.id());
    std::vector<std::uint8_t> pixels(std::size_t{4} * width * height);
    glReadPixels(0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
}

/// Averages blocks of kOversampling pixels and turns the rows over.
Image reduce(const std::vector<std::uint8_t>& pixels, unsigned width, unsigned height) {
    Image image{width, height, std::vector<std::uint8_t>(std::size_t{3} * width * height)};
    const std::size_t row = std::size_t{4} * width * kOversampling;
    constexpr unsigned kCount = kOversampling * kOversampling;
    for (unsigned y = 0; y < height; ++y)
        for (unsigned x = 0; x < width; ++x)
            for (unsigned c = 0; c < 3; ++c) {
                unsigned sum = kCount / 2;
                for (unsigned dy = 0; dy < kOversampling; ++dy)
                    for (unsigned dx = 0; dx < kOversampling; ++dx)
                        sum += pixels[(std::size_t{height - 1 - y} * kOversampling + dy) * row +
                                      std::size_t{4} * (std::size_t{x} * kOversampling + dx) + c];
                image.rgb[(std::size_t{y} * width + x) * 3 + c] = static_cast<std::uint8_t>(sum / kCount);
            }
    return image;
}

bool drawable(const Mesh& mesh) {
    return std::all_of(mesh.positions.begin(), mesh.positions.end(),
                       [](const Vec3& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); });
}

}  // namespace

Result<Image> draw_picture(const Mesh& mesh, const PictureOptions& options) {
    const unsigned sides[] = {options.width, options.height};
    if (std::any_of(std::begin(sides), std::end(sides), [](unsigned s) { return s < 1 || s > kMaxPictureSide; }))
        return Error{Errc::InvalidArgument, 0,
                     "a picture's sides are 1 to " + std::to_string(kMaxPictureSide) + " pixels, not " +
                         std::to_string(options.width) + "x" + std::to_string(options.height)};
    if (!drawable(mesh)) return Error{Errc::InvalidArgument, 0, "cannot draw a vertex that is not finite"};
    auto context = HeadlessGl::create();
    if (!context.ok()) return context.error();

    const unsigned width = options.width * kOversampling, height = options.height * kOversampling;
    const Canvas resolved(width, height, 0), canvas(width, height, kSamples);
    if (!resolved.complete() || !canvas.complete())
        return Error{Errc::Io, 0, "cannot draw: no framebuffer of that size"};
    const Camera camera = options.camera ? *options.camera
                                         : fit_camera(mesh, options.yaw, options.pitch,
                                                      static_cast<double>(options.width) / options.height);
    const Box box = bounding_box(mesh);
    const Backs backs = options.backs_in_place ? Backs::InPlace
                                               : backs_from_eye(bounds_solids(mesh), length(camera.eye - box.center()),
                                                                box.diagonal() / 2);
    const RenderOptions render{width, height, 1.2f * kOversampling, options.wireframe, options.flat, backs};
    if (auto drawn = render_frame(mesh, options.lines, camera, render); !drawn.ok()) return drawn.error();
    return reduce(read_back(canvas, resolved, width, height), options.width, options.height);
}

std::vector<Rgba8> heat_colors(const std::vector<double>& values, double top) {
    // From blue over cyan, green and yellow to red, as in Metro's pictures.
    constexpr std::array<Rgba8, 5> kStops{
        {{40, 70, 200, 255}, {50, 170, 210, 255}, {110, 200, 110, 255}, {240, 210, 70, 255}, {205, 40, 35, 255}}};
    const auto mix = [](std::uint8_t a, std::uint8_t b, double t) {
        return static_cast<std::uint8_t>(std::lround(a + (b - a) * t));
    };
    std::vector<Rgba8> colors;
    colors.reserve(values.size());
    for (const double value : values) {
        const double at = top > 0 ? std::clamp(value / top, 0.0, 1.0) * 4 : 0;
        const auto k = std::min<std::size_t>(3, static_cast<std::size_t>(at));
        const Rgba8 &a = kStops[k], &b = kStops[k + 1];
        const double t = at - static_cast<double>(k);
        colors.push_back({mix(a.r, b.r, t), mix(a.g, b.g, t), mix(a.b, b.b, t), 255});
    }
    return colors;
}

std::vector<std::vector<Vec3>> base_edge_lines(const BaseMesh& base, unsigned level,
                                               const std::vector<Vec3>& positions) {
    const std::uint32_t n = 1u << level;
    std::vector<std::vector<Vec3>> lines;
    lines.reserve(base.edge_count());
    for (const BaseEdge& e : base.edges()) {
        std::vector<Vec3>& line = lines.emplace_back();
        for (std::uint32_t t = 0; t <= n; ++t) {
            const std::uint32_t i = e.side[0] == 0 ? t : e.side[0] == 1 ? n - t : 0;
            const std::uint32_t k = e.side[0] == 0 ? 0 : e.side[0] == 1 ? t : n - t;
            line.push_back(positions[vertex_index(base, e.face[0], level, i, k)]);
        }
    }
    return lines;
}

}  // namespace mvw
