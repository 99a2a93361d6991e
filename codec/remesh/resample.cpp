#include "codec/remesh/resample.h"

#include <array>

#include "codec/mesh/vertex_data.h"

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

void take_vertex_data(const Mesh& mesh, const std::vector<FacePoint>& points, SemiRegularMesh& to) {
    to.colors.clear();
    to.fields.clear();
    for (const FacePoint& p : points) {
        const Face& f = mesh.faces[p.face];
        append_vertex_data(
            mesh,
            std::array{VertexShare{f[0], p.weight[0]}, VertexShare{f[1], p.weight[1]}, VertexShare{f[2], p.weight[2]}},
            to);
    }
}

}  // namespace mvw
