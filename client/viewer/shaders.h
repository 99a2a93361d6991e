// The programs that run on the graphics card (GLSL 3.30). Positions are relative to the eye, in units of the camera's
// distance; x right, y up, z towards the eye. Colours are lit in linear light and written to an sRGB framebuffer.
#pragma once

namespace mvw::shaders {

/// A triangle that covers the picture: light above, a little darker below.
inline constexpr const char* kBackgroundVertex = R"(#version 330 core
out float height;
void main() {
    vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    height = 0.5 * p.y + 0.5;
    gl_Position = vec4(p, 0.0, 1.0);
})";
inline constexpr const char* kBackgroundFragment = R"(#version 330 core
in float height;
out vec4 pixel;
void main() { pixel = vec4(mix(vec3(0.62, 0.64, 0.67), vec3(0.93, 0.94, 0.95), height), 1.0); })";

// Each point lies where it is in the picture, and has the depth of one that is `further` away from the eye
// (draw_sides.h).
inline constexpr const char* kSurfaceVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 color;
uniform mat3 turn;
uniform mat4 projection;
uniform float further;
out vec3 eye_position;
out vec3 eye_normal;
out vec3 albedo;
out vec3 barycentric;
void main() {
    eye_position = turn * position;
    eye_normal = turn * normal;
    albedo = pow(color.rgb, vec3(2.2));
    barycentric = vec3(gl_VertexID % 3 == 0, gl_VertexID % 3 == 1, gl_VertexID % 3 == 2);
    gl_Position = projection * vec4(eye_position, 1.0);
    if (further > 0.0 && gl_Position.w > 0.0) {
        vec4 behind = projection * vec4(eye_position.xy, eye_position.z - further, 1.0);
        gl_Position.z = behind.z * gl_Position.w / behind.w;
    }
})";

// A key light from the upper left, a weak one from the right, sky and ground, a soft highlight. Wire lines are drawn
// from barycentric coordinates, one width everywhere, and fade where triangles are too small on screen to tell apart.
inline constexpr const char* kSurfaceFragment = R"(#version 330 core
in vec3 eye_position;
in vec3 eye_normal;
in vec3 albedo;
in vec3 barycentric;
uniform float wire_width;
out vec4 pixel;
float wire() {
    vec3 rate = fwidth(barycentric);
    vec3 inside = smoothstep(vec3(0.0), rate * wire_width, barycentric);
    float fade = clamp(1.4 - 1.6 * wire_width * max(rate.x, max(rate.y, rate.z)), 0.3, 1.0);
    return (1.0 - min(inside.x, min(inside.y, inside.z))) * fade;
}
void main() {
    vec3 n = dot(eye_normal, eye_normal) > 0.0 ? normalize(eye_normal) : vec3(0.0, 0.0, 1.0);
    vec3 base = albedo;
    if (!gl_FrontFacing) {
        n = -n;
        base = mix(base, vec3(0.60, 0.05, 0.03), 0.85);
    }
    vec3 to_eye = normalize(-eye_position);
    vec3 key = normalize(vec3(-0.45, 0.60, 0.65)), fill = normalize(vec3(0.80, 0.05, 0.45));
    vec3 light = mix(vec3(0.16, 0.145, 0.13), vec3(0.30, 0.32, 0.35), 0.5 * n.y + 0.5)
               + vec3(0.78, 0.76, 0.72) * max(dot(n, key), 0.0) + vec3(0.15, 0.17, 0.20) * max(dot(n, fill), 0.0);
    float highlight = pow(max(dot(n, normalize(key + to_eye)), 0.0), 40.0);
    vec3 lit = base * light + vec3(0.06) * highlight;
    if (wire_width > 0.0) lit = mix(lit, vec3(0.012, 0.02, 0.035), 0.85 * wire());
    pixel = vec4(lit, 1.0);
})";

/// Lines come as ribbons that already face the picture.
inline constexpr const char* kLineVertex = R"(#version 330 core
layout(location = 0) in vec4 position;
void main() { gl_Position = position; })";
inline constexpr const char* kLineFragment = R"(#version 330 core
out vec4 pixel;
void main() { pixel = vec4(0.01, 0.04, 0.16, 1.0); })";

}  // namespace mvw::shaders
