#include "codec/mesh/solid.h"

#include <cstdint>
#include <numeric>
#include <vector>

#include "codec/mesh/disjoint_sets.h"
#include "codec/mesh/half_edges.h"

namespace mvw {
namespace {

/// Whether every component has its volume behind its faces.
bool face_outwards(std::span<const Face> faces, std::span<const Vec3> positions) {
    std::vector<std::uint32_t> parent(positions.size());
    std::iota(parent.begin(), parent.end(), 0u);
    for (const Face& f : faces)
        for (const std::uint32_t v : f) unite(parent, f[0], v);

    std::vector<double> volumes(positions.size(), 0.0);  // six times that of the component whose root it is
    for (const Face& f : faces) {
        // From one of the component's own vertices: solids far from the origin keep their digits.
        const std::uint32_t root = find_root(parent, f[0]);
        const Vec3 a = positions[f[0]] - positions[root], b = positions[f[1]] - positions[root],
                   c = positions[f[2]] - positions[root];
        volumes[root] += dot(a, cross(b, c));
    }
    for (const Face& f : faces)
        if (!(volumes[find_root(parent, f[0])] > 0)) return false;
    return !faces.empty();
}

}  // namespace

bool bounds_solids(const BaseMesh& base, std::span<const Vec3> positions) {
    const bool closed = 2 * std::uint64_t{base.edge_count()} == 3 * std::uint64_t{base.face_count()};
    return closed && face_outwards(base.faces(), positions.first(base.vertex_count()));
}

bool bounds_solids(const Mesh& mesh) {
    const EdgeGroups edges = group_edges(mesh.faces, static_cast<std::uint32_t>(mesh.positions.size()));
    for (std::size_t g = 0; g < edges.size(); ++g)
        if (edges[g].size() != 2 || origin(mesh.faces, edges[g][0]) == origin(mesh.faces, edges[g][1])) return false;
    return face_outwards(mesh.faces, mesh.positions);
}

}  // namespace mvw
