#include "tools/bench/folds.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "codec/mesh/clean.h"

namespace mvw::bench {
namespace {

constexpr double kFoldCosine = -0.7071;

}  // namespace

std::uint64_t count_folds(const Mesh& mesh) {
    std::vector<Vec3> normals;
    normals.reserve(mesh.faces.size());
    for (const Face& f : mesh.faces) {
        const Vec3& a = mesh.positions[f[0]];
        normals.push_back(normalized(cross(mesh.positions[f[1]] - a, mesh.positions[f[2]] - a)));
    }
    std::vector<std::pair<std::uint64_t, std::uint32_t>> sides;  // undirected edge, face
    sides.reserve(3 * mesh.faces.size());
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
        for (std::size_t s = 0; s < 3; ++s) {
            const std::uint64_t a = mesh.faces[f][s], b = mesh.faces[f][(s + 1) % 3];
            sides.emplace_back(std::min(a, b) << 32 | std::max(a, b), f);
        }
    std::sort(sides.begin(), sides.end());
    std::uint64_t folds = 0;
    for (std::size_t i = 1; i < sides.size(); ++i)
        if (sides[i].first == sides[i - 1].first &&
            dot(normals[sides[i].second], normals[sides[i - 1].second]) < kFoldCosine)
            ++folds;
    return folds;
}

Topology topology_of(const Mesh& mesh) {
    std::vector<std::uint32_t> component_of_face;
    Topology sum;
    for (const Component& c : components(mesh, component_of_face)) {
        ++sum.components;
        sum.boundary_loops += c.boundary_loops;
        sum.genus += c.genus;
    }
    return sum;
}

}  // namespace mvw::bench
