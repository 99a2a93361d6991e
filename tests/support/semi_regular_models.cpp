#include "tests/support/semi_regular_models.h"

#include <algorithm>
#include <map>

namespace mvw {

namespace {

/// The face whose four children start at children[4 k].
Face parent_of(const std::vector<Face>& children, std::size_t k) {
    const Face& middle = children[4 * k];
    Face out{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t child = 4 * k + 1; child < 4 * k + 4; ++child) {
            bool first = false, second = false;
            std::uint32_t tip = kNone;
            for (const std::uint32_t v : children[child]) {
                first |= v == middle[i];
                second |= v == middle[(i + 1) % 3];
                if (v != middle[i] && v != middle[(i + 1) % 3]) tip = v;
            }
            if (first && second) out[i] = tip;
        }
    return out;
}

using GridPoint = std::array<std::uint32_t, 2>;

/// Lays the descendants of faces[level][k] onto the grid of their base face.
void lay(const std::vector<std::vector<Face>>& faces, unsigned level, std::size_t k,
         const std::map<std::uint32_t, GridPoint>& corners, std::map<std::uint32_t, GridPoint>& grid) {
    for (const auto& [v, p] : corners) grid[v] = p;
    if (level + 1 == faces.size()) return;
    std::map<std::uint32_t, GridPoint> known = corners;
    const Face& middle = faces[level + 1][4 * k];
    // Corner i touches middle[i] and middle[i + 1]: middle[i + 1] halves the side from i to i + 1.
    const Face from_middle = parent_of(faces[level + 1], k);
    for (std::size_t i = 0; i < 3; ++i) {
        const GridPoint a = corners.at(from_middle[i]), b = corners.at(from_middle[(i + 1) % 3]);
        known[middle[(i + 1) % 3]] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
    }
    for (std::size_t child = 4 * k; child < 4 * k + 4; ++child) {
        std::map<std::uint32_t, GridPoint> own;
        for (const std::uint32_t v : faces[level + 1][child]) own[v] = known.at(v);
        lay(faces, level + 1, child, own, grid);
    }
}

}  // namespace

SemiRegularMesh from_level_order(const Mesh& mesh, unsigned levels) {
    std::vector<std::vector<Face>> faces = {mesh.faces};
    while (faces.size() <= levels && faces.front().size() % 4 == 0) {
        std::vector<Face> coarser(faces.front().size() / 4);
        for (std::size_t k = 0; k < coarser.size(); ++k) coarser[k] = parent_of(faces.front(), k);
        faces.insert(faces.begin(), std::move(coarser));
    }
    SemiRegularMesh out;
    out.levels = static_cast<unsigned>(faces.size() - 1);
    std::uint32_t base_vertices = 0;
    for (const Face& f : faces.front())
        for (const std::uint32_t v : f) base_vertices = std::max(base_vertices, v + 1);
    out.base = BaseMesh::create(base_vertices, faces.front()).value();
    out.positions.resize(mesh.positions.size());
    const std::uint32_t n = 1u << out.levels;
    for (std::uint32_t f = 0; f < out.base.face_count(); ++f) {
        const Face& c = faces.front()[f];
        std::map<std::uint32_t, GridPoint> grid;
        lay(faces, 0, f, {{c[0], {0, 0}}, {c[1], {n, 0}}, {c[2], {0, n}}}, grid);
        for (const auto& [v, p] : grid)
            out.positions[vertex_index(out.base, f, out.levels, p[0], p[1])] = mesh.positions[v];
    }
    return out;
}

SemiRegularMesh bumpy_ball(unsigned levels) {
    const BaseMesh base =
        BaseMesh::create(6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}})
            .value();
    const std::vector<Vec3> points = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    return refine(base, points, levels, [](const Vec3& p) {
        const Vec3 d = normalized(p);
        return d * (1 + 0.2 * std::sin(5 * d.x) * std::cos(4 * d.y + 1) + 0.05 * std::sin(11 * d.z + 3 * d.x));
    });
}

Mesh plain(const SemiRegularMesh& mesh) {
    Mesh out;
    out.positions = mesh.positions;
    out.faces = triangles_at_level(mesh.base, mesh.levels);
    return out;
}

}  // namespace mvw
