#include "codec/remesh/unfold.h"

#include "codec/mesh/semi_regular.h"

namespace mvw {

namespace {

constexpr int kMaxRounds = 30;
constexpr double kLeastAgreement =
    2.0 / 3;  // of a triangle's normals, the length of their mean: below, they say nothing

bool looks_away(const Face& f, const std::vector<Vec3>& normals, const std::vector<Vec3>& positions) {
    Vec3 outside;
    int count = 0;
    for (const std::uint32_t v : f)
        if (squared_length(normals[v]) > 0) outside += normals[v], ++count;
    if (count == 0 || length(outside) < kLeastAgreement * count) return false;
    return dot(cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]), outside) < 0;
}

/// Sums over what a vertex is joined to; an inner neighbour counts twice, which evens out.
struct Ring {
    Vec3 positions;
    double lengths = 0, count = 0;
};

}  // namespace

void unfold(const std::vector<Face>& triangles, const std::vector<Vec3>& normals,
            const std::vector<std::uint8_t>& fixed, std::vector<Vec3>& positions) {
    const std::vector<Vec3> start = positions;
    std::vector<std::uint32_t> slot(positions.size(), kNone), moving;
    std::vector<Ring> rings;
    for (int round = 0; round < kMaxRounds; ++round) {
        moving.clear();
        for (const Face& f : triangles) {
            if (!looks_away(f, normals, positions)) continue;
            for (const std::uint32_t v : f) {
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
