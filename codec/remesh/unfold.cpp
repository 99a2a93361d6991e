#include "codec/remesh/unfold.h"

#include "codec/mesh/half_edges.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

namespace {

constexpr double kFoldCosine = -0.5;
constexpr int kMaxRounds = 30;

/// The two triangles at an edge that may be folded.
using Hinge = std::array<std::uint32_t, 2>;

std::vector<Hinge> hinges_of(const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed) {
    std::vector<Hinge> hinges;
    const EdgeGroups groups = group_edges(triangles, static_cast<std::uint32_t>(fixed.size()));
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].size() != 2) continue;
        const std::uint32_t h = groups[g][0];
        if (fixed[origin(triangles, h)] != 0 && fixed[origin(triangles, next_half_edge(h))] != 0) continue;
        hinges.push_back({h / 3, groups[g][1] / 3});
    }
    return hinges;
}

/// The triangles at folded hinges, each once.
std::vector<std::uint32_t> folded(const std::vector<Face>& triangles, const std::vector<Hinge>& hinges,
                                  const std::vector<Vec3>& positions) {
    std::vector<Vec3> normals;
    normals.reserve(triangles.size());
    for (const Face& f : triangles)
        normals.push_back(normalized(cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]])));
    std::vector<std::uint32_t> faces;
    std::vector<std::uint8_t> listed(triangles.size(), 0);
    for (const Hinge& hinge : hinges) {
        if (dot(normals[hinge[0]], normals[hinge[1]]) > kFoldCosine) continue;
        for (const std::uint32_t f : hinge) {
            if (listed[f] == 0) faces.push_back(f);
            listed[f] = 1;
        }
    }
    return faces;
}

/// Sums over what a vertex is joined to; an inner neighbour counts twice, which evens out.
struct Ring {
    Vec3 positions;
    double lengths = 0, count = 0;
};

}  // namespace

void unfold(const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed, std::vector<Vec3>& positions) {
    const std::vector<Hinge> hinges = hinges_of(triangles, fixed);
    const std::vector<Vec3> start = positions;
    std::vector<std::uint32_t> slot(positions.size(), kNone), moving;
    std::vector<Ring> rings;
    for (int round = 0; round < kMaxRounds; ++round) {
        moving.clear();
        for (const std::uint32_t f : folded(triangles, hinges, positions)) {
            for (const std::uint32_t v : triangles[f]) {
                if (fixed[v] != 0 || slot[v] != kNone) continue;
                slot[v] = static_cast<std::uint32_t>(moving.size());
                moving.push_back(v);
            }
        }
        if (moving.empty()) return;
        rings.assign(moving.size(), {});
        for (const Face& f : triangles) {
            for (std::size_t k = 0; k < 3; ++k) {
                if (slot[f[k]] == kNone) continue;
                Ring& ring = rings[slot[f[k]]];
                for (const std::uint32_t u : {f[(k + 1) % 3], f[(k + 2) % 3]}) {
                    ring.positions += positions[u];
                    ring.lengths += length(positions[u] - positions[f[k]]);
                    ++ring.count;
                }
            }
        }
        for (std::size_t k = 0; k < moving.size(); ++k) {
            const std::uint32_t v = moving[k];
            slot[v] = kNone;
            const Vec3 to = (positions[v] + rings[k].positions / rings[k].count) * 0.5;
            if (length(to - start[v]) <= rings[k].lengths / rings[k].count) positions[v] = to;
        }
    }
}

}  // namespace mvw
