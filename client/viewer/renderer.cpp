#include "client/viewer/renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <numbers>
#include <string>

#include "client/viewer/corners.h"
#include "client/viewer/draw_sides.h"
#include "client/viewer/shaders.h"

namespace mvw {
namespace {

constexpr Rgba8 kClay{205, 200, 190, 255};

/// Column-major matrix.
using Matrix4 = std::array<float, 16>;

/// A linked program; 0 where it did not link.
class Program {
 public:
    Program(const char* vertex, const char* fragment) : id_(glCreateProgram()) {
        for (const auto& [kind, text] :
             {std::pair{GL_VERTEX_SHADER, vertex}, std::pair{GL_FRAGMENT_SHADER, fragment}}) {
            const GLuint shader = glCreateShader(static_cast<GLenum>(kind));
            glShaderSource(shader, 1, &text, nullptr);
            glCompileShader(shader);
            glAttachShader(id_, shader);
            glDeleteShader(shader);
        }
        glLinkProgram(id_);
    }
    ~Program() { glDeleteProgram(id_); }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    [[nodiscard]] Result<void> use() const {
        GLint linked = 0;
        glGetProgramiv(id_, GL_LINK_STATUS, &linked);
        if (linked == 0) {
            std::array<char, 512> log{};
            glGetProgramInfoLog(id_, log.size(), nullptr, log.data());
            return Error{Errc::Io, 0, std::string("cannot draw: shader refused: ") + log.data()};
        }
        glUseProgram(id_);
        return {};
    }
    [[nodiscard]] GLint uniform(const char* name) const { return glGetUniformLocation(id_, name); }

 private:
    GLuint id_;
};

/// A vertex array and the buffer that it reads.
class Vertices {
 public:
    Vertices(const void* data, std::size_t bytes) {
        glGenVertexArrays(1, &array_);
        glBindVertexArray(array_);
        glGenBuffers(1, &buffer_);
        glBindBuffer(GL_ARRAY_BUFFER, buffer_);
        glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
    }
    ~Vertices() {
        glDeleteBuffers(1, &buffer_);
        glDeleteVertexArrays(1, &array_);
    }
    Vertices(const Vertices&) = delete;
    Vertices& operator=(const Vertices&) = delete;

    static void attribute(GLuint slot, GLint size, GLenum type, bool unit, std::size_t stride, std::size_t offset) {
        glVertexAttribPointer(
            slot, size, type, unit ? GL_TRUE : GL_FALSE, static_cast<GLsizei>(stride),
            reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr): OpenGL's way
        glEnableVertexAttribArray(slot);
    }

 private:
    GLuint array_ = 0, buffer_ = 0;
};

/// Nearest and farthest vertex in front of the eye, backs a step further away, in units of the camera's distance.
std::array<double, 2> depth_range(const Mesh& mesh, const Camera& camera, double back_step) {
    const Vec3 backward = camera.backward();
    double nearest = 1e9, farthest = 0;
    for (const Face& f : mesh.faces)
        for (const std::uint32_t v : f) {
            const double depth = -dot((mesh.positions[v] - camera.eye) / camera.distance, backward);
            nearest = std::min(nearest, depth);
            farthest = std::max(farthest, depth);
        }
    nearest = std::max(0.98 * nearest, 0.01);
    farthest += back_step;
    return {nearest, std::max(1.02 * farthest, 1.01 * nearest)};
}

Matrix4 perspective(const std::array<double, 2>& depth, double aspect) {
    const double f = 1 / std::tan(Camera::kFieldOfView / 2 * (std::numbers::pi / 180));
    const double range = depth[0] - depth[1];
    Matrix4 m{};
    m[0] = static_cast<float>(f / aspect);
    m[5] = static_cast<float>(f);
    m[10] = static_cast<float>((depth[0] + depth[1]) / range);
    m[11] = -1;
    m[14] = static_cast<float>(2 * depth[0] * depth[1] / range);
    return m;
}

Result<void> draw_background() {
    const Program program(shaders::kBackgroundVertex, shaders::kBackgroundFragment);
    if (auto used = program.use(); !used.ok()) return used.error();
    const Vertices none(nullptr, 0);
    glDisable(GL_DEPTH_TEST);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return {};
}

Result<void> draw_surface(const Mesh& mesh, const Camera& camera, const Matrix4& projection, double back_step,
                          const RenderOptions& options) {
    const Program program(shaders::kSurfaceVertex, shaders::kSurfaceFragment);
    if (auto used = program.use(); !used.ok()) return used.error();
    const Vec3 right = camera.right(), up = camera.up(), backward = camera.backward();
    std::array<float, 9> turn{};
    for (std::size_t k = 0; k < 3; ++k) {
        turn[3 * k] = static_cast<float>(right[k]);
        turn[3 * k + 1] = static_cast<float>(up[k]);
        turn[3 * k + 2] = static_cast<float>(backward[k]);
    }
    glUniformMatrix3fv(program.uniform("turn"), 1, GL_FALSE, turn.data());
    glUniformMatrix4fv(program.uniform("projection"), 1, GL_FALSE, projection.data());
    glUniform1f(program.uniform("wire_width"), options.wireframe ? 0.7f * options.line_width : 0.0f);

    const std::vector<Corner> corners = make_corners(mesh, camera.eye, camera.distance, options.flat, kClay);
    const Vertices vertices(corners.data(), corners.size() * sizeof(Corner));
    Vertices::attribute(0, 3, GL_FLOAT, false, sizeof(Corner), offsetof(Corner, position));
    Vertices::attribute(1, 3, GL_FLOAT, false, sizeof(Corner), offsetof(Corner, normal));
    Vertices::attribute(2, 4, GL_UNSIGNED_BYTE, true, sizeof(Corner), offsetof(Corner, color));
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    draw_sides(options.backs, program.uniform("further"), back_step,
               [&] { glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners.size())); });
    return {};
}

/// A point in clip space, brought a little nearer so that lines on the surface win against it.
std::array<double, 4> line_point(const Vec3& p, const Camera& camera, const Matrix4& m) {
    const Vec3 d = (p - camera.eye) / camera.distance * 0.998;
    const double x = dot(d, camera.right()), y = dot(d, camera.up()), z = dot(d, camera.backward());
    return {m[0] * x, m[5] * y, m[10] * z + m[14], -z};
}

/// Two triangles of the line's width around each segment in front of the eye.
std::vector<float> make_ribbons(const std::vector<std::vector<Vec3>>& lines, const Camera& camera,
                                const Matrix4& projection, const RenderOptions& options) {
    std::vector<float> out;
    const auto put = [&](const std::array<double, 4>& p, double dx, double dy) {
        for (const double c : {p[0] + dx * p[3], p[1] + dy * p[3], p[2], p[3]}) out.push_back(static_cast<float>(c));
    };
    for (const std::vector<Vec3>& line : lines)
        for (std::size_t i = 1; i < line.size(); ++i) {
            const auto a = line_point(line[i - 1], camera, projection), b = line_point(line[i], camera, projection);
            if (a[3] <= 0 || b[3] <= 0) continue;
            const double x = (b[0] / b[3] - a[0] / a[3]) * options.width,
                         y = (b[1] / b[3] - a[1] / a[3]) * options.height;
            const double l = std::hypot(x, y);
            if (l == 0) continue;
            const double dx = -y / l * options.line_width / options.width,
                         dy = x / l * options.line_width / options.height;
            put(a, dx, dy), put(a, -dx, -dy), put(b, dx, dy);
            put(b, dx, dy), put(a, -dx, -dy), put(b, -dx, -dy);
        }
    return out;
}

Result<void> draw_lines(const std::vector<std::vector<Vec3>>& lines, const Camera& camera, const Matrix4& projection,
                        const RenderOptions& options) {
    const Program program(shaders::kLineVertex, shaders::kLineFragment);
    if (auto used = program.use(); !used.ok()) return used.error();
    const std::vector<float> ribbons = make_ribbons(lines, camera, projection, options);
    const Vertices vertices(ribbons.data(), ribbons.size() * sizeof(float));
    Vertices::attribute(0, 4, GL_FLOAT, false, 4 * sizeof(float), 0);
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(ribbons.size() / 4));
    return {};
}

}  // namespace

Result<void> render_frame(const Mesh& mesh, const std::vector<std::vector<Vec3>>& lines, const Camera& camera,
                          const RenderOptions& options) {
    const double back_step = kBackStep * bounding_box(mesh).diagonal() / camera.distance;
    const Matrix4 projection =
        perspective(depth_range(mesh, camera, back_step), static_cast<double>(options.width) / options.height);
    glViewport(0, 0, static_cast<GLsizei>(options.width), static_cast<GLsizei>(options.height));
    glEnable(GL_FRAMEBUFFER_SRGB);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (auto done = draw_background(); !done.ok()) return done.error();
    if (auto done = draw_surface(mesh, camera, projection, back_step, options); !done.ok()) return done.error();
    if (!lines.empty())
        if (auto done = draw_lines(lines, camera, projection, options); !done.ok()) return done.error();
    if (glGetError() != GL_NO_ERROR) return Error{Errc::Io, 0, "cannot draw: OpenGL refused (out of memory?)"};
    return {};
}

}  // namespace mvw
