#include "client/viewer/window/live_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "client/viewer/draw_sides.h"
#include "client/viewer/shaders.h"

namespace mvw::client {
namespace {

constexpr const char* kSurfaceVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 color;
uniform mat4 view;
uniform mat4 projection;
uniform float further;
out vec3 at;
out vec3 way;
out vec3 albedo;
void main() {
    vec4 p = view * vec4(position, 1.0);
    at = p.xyz;
    way = mat3(view) * normal;
    albedo = pow(color.rgb, vec3(2.2));
    gl_Position = projection * p;
    if (further > 0.0 && gl_Position.w > 0.0) {
        p.z -= further;
        p = projection * p;
        gl_Position.z = p.z * gl_Position.w / p.w;
    }
})";

// Along a sharp edge the averaged normal is no side's: the facet's own takes its place.
constexpr const char* kSurfaceFragment = R"(#version 330 core
in vec3 at;
in vec3 way;
in vec3 albedo;
uniform bool flatly;
out vec4 pixel;
void main() {
    vec3 facet = normalize(cross(dFdx(at), dFdy(at)));
    vec3 n = dot(way, way) > 0.0 ? normalize(way) : facet;
    vec3 base = albedo;
    if (!gl_FrontFacing) {
        n = -n;
        base = vec3(0.45, 0.09, 0.05);
    }
    if (dot(facet, at) > 0.0) facet = -facet;
    if (flatly || dot(n, facet) < 0.72) n = facet;
    vec3 eye = normalize(-at);
    vec3 key = normalize(vec3(-0.45, 0.60, 0.65)), fill = normalize(vec3(0.80, 0.05, 0.45));
    vec3 light = mix(vec3(0.16, 0.145, 0.13), vec3(0.30, 0.32, 0.35), 0.5 * n.y + 0.5)
               + vec3(0.85, 0.82, 0.78) * max(dot(n, key), 0.0) + vec3(0.15, 0.17, 0.20) * max(dot(n, fill), 0.0);
    vec3 lit = base * light + vec3(0.06) * pow(max(dot(n, normalize(key + eye)), 0.0), 40.0);
    pixel = vec4(pow(lit, vec3(1.0 / 2.2)), 1.0);
})";

constexpr const char* kLineVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 view;
uniform mat4 projection;
uniform float nearer;
void main() {
    gl_Position = projection * (view * vec4(position, 1.0));
    gl_Position.z -= nearer * gl_Position.w;
})";
constexpr const char* kLineFragment = R"(#version 330 core
uniform vec4 ink;
out vec4 pixel;
void main() { pixel = ink; })";

Result<unsigned> link(const char* vertex, const char* fragment) {
    const GLuint program = glCreateProgram();
    for (const auto& [kind, text] : {std::pair{GL_VERTEX_SHADER, vertex}, std::pair{GL_FRAGMENT_SHADER, fragment}}) {
        const GLuint shader = glCreateShader(static_cast<GLenum>(kind));
        glShaderSource(shader, 1, &text, nullptr);
        glCompileShader(shader);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(program);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != 0) return static_cast<unsigned>(program);
    std::array<char, 512> log{};
    glGetProgramInfoLog(program, log.size(), nullptr, log.data());
    return Error{Errc::Io, 0, std::string("cannot draw: shader refused: ") + log.data()};
}

void set_matrices(unsigned program, const Turntable& camera) {
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "view"), 1, GL_FALSE, camera.view.data());
    glUniformMatrix4fv(glGetUniformLocation(program, "projection"), 1, GL_FALSE, camera.projection.data());
}

template <typename T>
void fill(unsigned target, unsigned buffer, const std::vector<T>& values) {
    glBindBuffer(target, buffer);
    glBufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(), GL_DYNAMIC_DRAW);
}

}  // namespace

void Turntable::fit(const Drawable& drawable) {
    Box box;
    for (const std::uint32_t v : drawable.triangles) box.add(to_double(drawable.positions[v]));
    middle = box.empty() ? Vec3f{} : to_float(box.center());
    radius = box.diagonal() > 0 ? static_cast<float>(box.diagonal() / 2) : 1.0f;
}

void Turntable::aim(double aspect, double covered) {
    constexpr double kHalfField = 14 * std::numbers::pi / 180;
    const double tangent = std::tan(kHalfField), r = static_cast<double>(radius);
    const double fit_distance = 0.85 * r / std::sin(kHalfField) / std::min(1.0, aspect * (1 - covered));
    const double distance = std::max(fit_distance / zoom, 0.02 * r);
    const double y = yaw * std::numbers::pi / 180, p = pitch * std::numbers::pi / 180;
    std::array<Vec3, 3> rows{Vec3{std::cos(y), 0, -std::sin(y)},
                             Vec3{-std::sin(y) * std::sin(p), std::cos(p), -std::cos(y) * std::sin(p)},
                             Vec3{std::sin(y) * std::cos(p), std::sin(p), std::cos(y) * std::cos(p)}};
    if (z_up)
        for (Vec3& row : rows) row = {row.x, -row.z, row.y};
    const double height = 2 * fit_distance * tangent;
    const Vec3 shift{pan_x * height, pan_y * height, -distance};
    eye_to_middle = length(shift);
    view.fill(0);
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t c = 0; c < 3; ++c) view[4 * c + k] = static_cast<float>(rows[k][c]);
        view[12 + k] = static_cast<float>(shift[k] - dot(rows[k], to_double(middle)));
    }
    view[15] = 1;
    const double near = std::max(distance - 2.5 * r, 0.01 * distance), far = distance + 2.5 * r;
    projection.fill(0);
    projection[0] = static_cast<float>(1 / (tangent * aspect));
    projection[5] = static_cast<float>(1 / tangent);
    projection[8] = static_cast<float>(-covered);
    projection[10] = static_cast<float>(-(far + near) / (far - near));
    projection[11] = -1;
    projection[14] = static_cast<float>(-2 * far * near / (far - near));
}

LiveRenderer::~LiveRenderer() {
    if (array_ == 0) return;
    glDeleteBuffers(static_cast<GLsizei>(buffers_.size()), buffers_.data());
    glDeleteVertexArrays(1, &array_);
    glDeleteVertexArrays(1, &empty_);
    for (const unsigned program : {surface_, lines_, background_}) glDeleteProgram(program);
}

Result<void> LiveRenderer::start() {
    const std::array<std::pair<const char*, const char*>, 3> sources{
        std::pair{kSurfaceVertex, kSurfaceFragment}, std::pair{kLineVertex, kLineFragment},
        std::pair{shaders::kBackgroundVertex, shaders::kBackgroundFragment}};
    const std::array<unsigned*, 3> programs{&surface_, &lines_, &background_};
    for (std::size_t k = 0; k < 3; ++k) {
        const Result<unsigned> program = link(sources[k].first, sources[k].second);
        if (!program.ok()) return program.error();
        *programs[k] = *program;
    }
    glGenVertexArrays(1, &array_);
    glGenVertexArrays(1, &empty_);
    glGenBuffers(static_cast<GLsizei>(buffers_.size()), buffers_.data());
    return {};
}

void LiveRenderer::upload(const Drawable& d) {
    glBindVertexArray(array_);
    fill(GL_ARRAY_BUFFER, buffers_[0], d.positions);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    glEnableVertexAttribArray(0);
    fill(GL_ARRAY_BUFFER, buffers_[1], d.normals);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    glEnableVertexAttribArray(1);
    solid_ = d.solid;
    colored_ = !d.colors.empty();
    if (colored_) {
        fill(GL_ARRAY_BUFFER, buffers_[2], d.colors);
        glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
    }
    const std::array<const std::vector<std::uint32_t>*, 3> indices{&d.triangles, &d.edges, &d.base_edges};
    for (std::size_t k = 0; k < 3; ++k) {
        fill(GL_ELEMENT_ARRAY_BUFFER, buffers_[3 + k], *indices[k]);
        counts_[k] = static_cast<int>(indices[k]->size());
    }
}

void LiveRenderer::draw_elements(unsigned mode, unsigned which) const {
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[3 + which]);
    glDrawElements(mode, counts_[which], GL_UNSIGNED_INT, nullptr);
}

void LiveRenderer::draw(const Turntable& camera, const LiveLook& look) const {
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glDisable(GL_DEPTH_TEST);
    glBindVertexArray(empty_);
    glUseProgram(background_);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    if (counts_[0] == 0) return;

    glEnable(GL_DEPTH_TEST);
    glBindVertexArray(array_);
    set_matrices(surface_, camera);
    glUniform1i(glGetUniformLocation(surface_, "flatly"), look.flat ? 1 : 0);
    if (colored_ && look.colors) {
        glEnableVertexAttribArray(2);
    } else {
        glDisableVertexAttribArray(2);
        glVertexAttrib4f(2, 0.82f, 0.79f, 0.74f, 1);
    }
    const double radius = static_cast<double>(camera.radius);
    draw_sides(backs_from_eye(solid_, camera.eye_to_middle, radius), glGetUniformLocation(surface_, "further"),
               kBackStep * 2 * radius, [&] { draw_elements(GL_TRIANGLES, 0); });
    set_matrices(lines_, camera);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    const auto draw_lines = [&](unsigned which, float nearer, const std::array<float, 4>& ink) {
        glUniform1f(glGetUniformLocation(lines_, "nearer"), nearer);
        glUniform4fv(glGetUniformLocation(lines_, "ink"), 1, ink.data());
        draw_elements(GL_LINES, which);
    };
    if (look.edges) draw_lines(1, 1e-4f, {0.05f, 0.07f, 0.10f, 0.5f});
    if (look.base_edges) draw_lines(2, 3e-4f, {0.80f, 0.32f, 0.02f, 1});
    glDisable(GL_BLEND);
}

}  // namespace mvw::client
