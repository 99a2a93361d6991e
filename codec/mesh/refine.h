// A semi-regular mesh by formula.
#pragma once
#include <utility>
#include <vector>

#include "codec/mesh/semi_regular.h"

namespace mvw {

/// A base with corners `points` refined `levels` times by midpoints, each point of the finest level put where
/// `place`, Vec3 -> Vec3, says.
template <typename Place>
SemiRegularMesh refine(BaseMesh base, const std::vector<Vec3>& points, unsigned levels, Place place) {
    SemiRegularMesh out{{}, levels, std::vector<Vec3>(vertices_at_level(base, levels)), {}, {}, {}};
    std::vector<std::uint32_t> patch;
    const unsigned n = 1u << levels;
    for (std::uint32_t f = 0; f < base.face_count(); ++f) {
        patch_vertices(base, f, levels, patch);
        const Face& c = base.faces()[f];
        std::size_t at = 0;
        for (unsigned i = 0; i <= n; ++i)
            for (unsigned k = 0; i + k <= n; ++k) {
                const double u = double(i) / n, v = double(k) / n;
                out.positions[patch[at++]] = place(points[c[0]] * (1 - u - v) + points[c[1]] * u + points[c[2]] * v);
            }
    }
    out.base = std::move(base);
    return out;
}

}  // namespace mvw
