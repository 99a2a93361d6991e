#include "codec/remesh/settle.h"

#include <algorithm>

#include "codec/measure/surface_index.h"
#include "codec/mesh/semi_regular.h"
#include "codec/remesh/fit.h"
#include "codec/remesh/iron.h"
#include "codec/remesh/parallel.h"
#include "codec/remesh/unfold.h"

namespace mvw {

namespace {

constexpr std::size_t kMuch = 1000;   // vertices for each that was ironed, at most
constexpr double kMostFarther = 1.5;  // times as far from the surface as before ...
constexpr double kNear = 1e-4;        // ... or so much of the diagonal: ironing may leave the input's vertices

/// The triangles that are nearest to vertices of the input which have lost touch with the surface since `before`.
std::vector<std::uint32_t> triangles_missed(const Mesh& input, const std::vector<Face>& triangles,
                                            const std::vector<Vec3>& before, const std::vector<Vec3>& after,
                                            unsigned threads) {
    const SurfaceIndex old(before, triangles, threads), now(after, triangles, threads);
    const double near = kNear * bounding_box(input).diagonal();
    std::vector<std::uint32_t> missed(input.positions.size(), kNone);
    parallel_slices(missed.size(), threads, [&](std::size_t begin, std::size_t end) {
        std::uint32_t face = kNone;
        for (std::size_t k = begin; k < end; ++k) {
            const SurfacePoint hit = old.closest(input.positions[k], face);
            face = hit.face;
            if (std::ranges::all_of(triangles[face], [&](std::uint32_t v) { return before[v] == after[v]; })) continue;
            if (now.closest(input.positions[k], face).distance > std::max(kMostFarther * hit.distance, near))
                missed[k] = face;
        }
    });
    std::erase(missed, kNone);
    return missed;
}

/// iron(), but for what it would uncover.
std::size_t iron_covered(const Mesh& input, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
                         unsigned threads, std::vector<Vec3>& positions) {
    const std::vector<Vec3> before = positions;
    const std::size_t moved = iron(triangles, fixed, positions);
    if (moved == 0) return 0;
    for (const std::uint32_t t : triangles_missed(input, triangles, before, positions, threads))
        for (const std::uint32_t v : triangles[t]) positions[v] = before[v];
    return moved;
}

}  // namespace

void settle(const Mesh& input, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
            const std::vector<Vec3>& normals, const SettleOptions& options, std::vector<Vec3>& positions) {
    const unsigned threads = options.threads;
    FitOptions fitting;
    fitting.threads = threads;
    fitting.rounds = options.rounds;
    fit(input, triangles, fixed, fitting, positions);
    unfold(triangles, normals, fixed, positions);
    const std::size_t ironed = iron_covered(input, triangles, fixed, threads, positions);
    if (!options.again || ironed * kMuch < positions.size()) return;
    fitting.rounds = 1;
    fit(input, triangles, fixed, fitting, positions);
    iron_covered(input, triangles, fixed, threads, positions);
}

}  // namespace mvw
