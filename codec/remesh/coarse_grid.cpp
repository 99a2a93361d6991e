#include "codec/remesh/coarse_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "codec/remesh/resample.h"

namespace mvw {

// A face's triangles at level j, n = 2^j: rows of rising i; row i starts at i (2n - i) and holds, by rising k, the
// upright triangle (i,k) (i+1,k) (i,k+1) and, but in the last place, the turned one (i+1,k) (i+1,k+1) (i,k+1).

FacePoint on_level(const FacePoint& point, unsigned level) {
    const std::uint32_t n = 1u << level;
    const double x = point.weight[1] * n, y = point.weight[2] * n;
    const auto cell = [&](double at, std::uint32_t most) {
        return std::min(static_cast<std::uint32_t>(std::max(at, 0.0)), most);
    };
    const std::uint32_t i = cell(x, n - 1), k = cell(y, n - 1 - i);
    const double u = x - i, v = y - k;
    const bool upright = u + v <= 1 || i + k + 1 == n;
    const std::uint32_t triangle = point.face * n * n + i * (2 * n - i) + 2 * k + (upright ? 0 : 1);
    if (upright) return {triangle, {1 - u - v, u, v}};
    return {triangle, {1 - v, u + v - 1, 1 - u}};
}

FacePoint on_base(const FacePoint& point, unsigned level) {
    const std::uint32_t n = 1u << level, place = point.face % (n * n);
    const double root = std::sqrt(static_cast<double>(n) * n - place);
    const auto i = n - static_cast<std::uint32_t>(std::ceil(root));  // the last row that starts at or before the place
    const std::uint32_t in_row = place - i * (2 * n - i), k = in_row / 2;
    const bool upright = in_row % 2 == 0;
    const auto& w = point.weight;
    const double x = (i + (upright ? w[1] : w[0] + w[1])) / n, y = (k + (upright ? w[2] : w[1] + w[2])) / n;
    return {point.face / (n * n), {1 - x - y, x, y}};
}

std::vector<Vec3> interpolate(const BaseMesh& base, unsigned coarse, const std::vector<Vec3>& values, unsigned level) {
    const std::vector<Face> triangles = triangles_at_level(base, coarse);
    std::vector<std::uint32_t> faces(base.face_count());
    std::iota(faces.begin(), faces.end(), 0);
    std::vector<Vec3> out;
    out.reserve(vertices_at_level(base, level));
    for (const FacePoint& point : grid_points(base, level, faces)) {
        const FacePoint p = on_level(point, coarse);
        const Face& f = triangles[p.face];
        out.push_back(values[f[0]] * p.weight[0] + values[f[1]] * p.weight[1] + values[f[2]] * p.weight[2]);
    }
    return out;
}

}  // namespace mvw
