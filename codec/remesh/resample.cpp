#include "codec/remesh/resample.h"

#include <algorithm>
#include <array>

namespace mvw {

std::vector<FacePoint> grid_points(const BaseMesh& base, unsigned level, const std::vector<std::uint32_t>& face_ids) {
    const std::uint32_t n = 1u << level;
    std::vector<FacePoint> points(vertices_at_level(base, level));
    std::vector<std::uint32_t> patch;
    for (std::uint32_t f = 0; f < base.face_count(); ++f) {
        patch_vertices(base, f, level, patch);
        std::size_t at = 0;
        for (std::uint32_t i = 0; i <= n; ++i) {
            for (std::uint32_t k = 0; i + k <= n; ++k) {
                const double scale = 1.0 / n;
                points[patch[at++]] = {face_ids[f], {(n - i - k) * scale, i * scale, k * scale}};
            }
        }
    }
    return points;
}

std::vector<Vec3> positions_of(const Mesh& mesh, const std::vector<FacePoint>& points) {
    std::vector<Vec3> positions;
    positions.reserve(points.size());
    for (const FacePoint& p : points) {
        const Face& f = mesh.faces[p.face];
        positions.push_back(mesh.positions[f[0]] * p.weight[0] + mesh.positions[f[1]] * p.weight[1] +
                            mesh.positions[f[2]] * p.weight[2]);
    }
    return positions;
}

std::vector<Rgba8> colors_of(const Mesh& mesh, const std::vector<FacePoint>& points) {
    std::vector<Rgba8> colors;
    if (mesh.colors.empty()) return colors;
    colors.reserve(points.size());
    for (const FacePoint& p : points) {
        const Face& f = mesh.faces[p.face];
        std::array<double, 4> sum{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Rgba8& c = mesh.colors[f[k]];
            sum[0] += p.weight[k] * c.r, sum[1] += p.weight[k] * c.g;
            sum[2] += p.weight[k] * c.b, sum[3] += p.weight[k] * c.a;
        }
        const auto byte = [](double x) { return static_cast<std::uint8_t>(std::clamp(x + 0.5, 0.0, 255.0)); };
        colors.push_back({byte(sum[0]), byte(sum[1]), byte(sum[2]), byte(sum[3])});
    }
    return colors;
}

}  // namespace mvw
