#include "client/viewer/corners.h"

#include <cmath>

#include "codec/mesh/material_colors.h"

namespace mvw {
namespace {

constexpr double kCreaseCosine = 0.766;  // cos 40 degrees
constexpr std::uint32_t kFanLimit = 64;  // vertices of more triangles than this are left faceted: keeps time linear

/// Triangles around each vertex: those of v are list[begin[v] .. begin[v + 1]).
struct Fans {
    std::vector<std::uint32_t> begin, list;

    explicit Fans(const Mesh& mesh) : begin(mesh.positions.size() + 1, 0), list(3 * mesh.faces.size()) {
        for (const Face& f : mesh.faces)
            for (const std::uint32_t v : f) ++begin[v + 1];
        for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
        std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
            for (const std::uint32_t v : mesh.faces[f]) list[next[v]++] = f;
    }
};

std::vector<Vec3> area_vectors(const Mesh& mesh, const Vec3& origin, double scale) {
    std::vector<Vec3> areas;
    areas.reserve(mesh.faces.size());
    for (const Face& f : mesh.faces) {
        const Vec3 a = (mesh.positions[f[0]] - origin) / scale;
        areas.push_back(
            cross((mesh.positions[f[1]] - origin) / scale - a, (mesh.positions[f[2]] - origin) / scale - a));
    }
    return areas;
}

Vec3 smooth_normal(const std::vector<Vec3>& areas, const Fans& fans, std::uint32_t face, std::uint32_t vertex) {
    const Vec3 own = normalized(areas[face]);
    const std::uint32_t first = fans.begin[vertex], last = fans.begin[vertex + 1];
    if (last - first > kFanLimit) return own;
    Vec3 sum{};
    for (std::uint32_t i = first; i < last; ++i) {
        const Vec3& area = areas[fans.list[i]];
        if (dot(area, own) >= kCreaseCosine * length(area)) sum += area;
    }
    return normalized(sum);
}

}  // namespace

std::vector<Corner> make_corners(const Mesh& mesh, const Vec3& origin, double scale, bool flat, const Rgba8& plain) {
    const std::vector<Vec3> areas = area_vectors(mesh, origin, scale);
    const Fans fans(mesh);
    std::vector<Corner> corners;
    corners.reserve(3 * mesh.faces.size());
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        const Rgba8* material = color_of(mesh.material_colors, mesh.materials.empty() ? 0 : mesh.materials[f]);
        for (const std::uint32_t v : mesh.faces[f]) {
            const Rgba8 own = mesh.colors.empty() ? plain : mesh.colors[v];
            const Vec3 normal = flat ? normalized(areas[f]) : smooth_normal(areas, fans, f, v);
            corners.push_back({to_float((mesh.positions[v] - origin) / scale), to_float(normal),
                               material != nullptr ? *material : own});
        }
    }
    return corners;
}

}  // namespace mvw
