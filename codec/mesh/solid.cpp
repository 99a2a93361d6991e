#include "codec/mesh/solid.h"

#include <numeric>

#include "codec/mesh/disjoint_sets.h"

namespace mvw {

bool bounds_solids(const BaseMesh& base, std::span<const Vec3> positions) {
    if (2 * std::uint64_t{base.edge_count()} != 3 * std::uint64_t{base.face_count()}) return false;
    std::vector<std::uint32_t> parent(base.vertex_count());
    std::iota(parent.begin(), parent.end(), 0u);
    for (const Face& f : base.faces())
        for (const std::uint32_t v : f) unite(parent, f[0], v);

    std::vector<double> volumes(base.vertex_count(), 0.0);  // of the component whose root it is
    for (const Face& f : base.faces()) {
        // From one of the component's own vertices: solids far from the origin keep their digits.
        const std::uint32_t root = find_root(parent, f[0]);
        const Vec3 a = positions[f[0]] - positions[root], b = positions[f[1]] - positions[root],
                   c = positions[f[2]] - positions[root];
        volumes[root] += dot(a, cross(b, c));
    }
    for (const Face& f : base.faces())
        if (!(volumes[find_root(parent, f[0])] > 0)) return false;
    return base.face_count() > 0;
}

bool bounds_solids(const Mesh& mesh) {
    const auto surface = BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces);
    return surface.ok() && bounds_solids(*surface, mesh.positions);
}

}  // namespace mvw
