#include "codec/transform/subdivide.h"

#include <cassert>

#include "codec/transform/lifting.h"
#include "codec/transform/stencils.h"

namespace mvw {

namespace {

// The even rule at extraordinary vertices, for s = 36/31: x2 and alpha.
constexpr double kX2 = -0.25, kAlpha = 64.0 / 29;

/// [v, x] times a 2 x 2 matrix, given row by row, added to [v', x'].
void add(const Vec3& v, const Vec3& x, const LatticeMasks::Matrix& m, Vec3& v_out, Vec3& x_out) {
    v_out += v * m[0] + x * m[2];
    x_out += v * m[1] + x * m[3];
}

struct Rules {
    LatticeMasks regular = interpolatory_masks();
    LatticeMasks::Matrix H_n, H, J_3, K_3;

    explicit Rules(double s)
        : H_n{1, kAlpha / 16, 0, kX2},
          H{0, -kAlpha / 16, 0, -27 * kAlpha / (8 * (54 - 31 * s))},
          J_3{31 * s / 72, 0, 0.25, 7.0 / 36},
          K_3{0.5 - 31 * s / 72, 0, 0.25, 1.0 / 36} {}
};

void even(const Level& level, const Rules& rules, const ShapedPoints& in, ShapedPoints& out) {
    for (std::uint32_t i = 0; i < level.vertex_count; ++i) {
        out.v[i] = in.v[i];
        if (level.sharp(i) || level.valence[i] == 0) continue;
        Vec3 v, ring_v, ring_x;
        for (const std::uint32_t e : level.edges_at(i)) {
            ring_v += in.v[level.other_end(e, i)];
            ring_x += in.x[level.other_end(e, i)];
        }
        const bool regular = level.regular(i);
        const double share = regular ? 1 : 1.0 / level.valence[i];
        add(in.v[i], in.x[i], regular ? rules.regular.G : rules.H_n, v, out.x[i]);
        add(ring_v * share, ring_x * share, regular ? rules.regular.L : rules.H, v, out.x[i]);
    }
}

void odd(const Level& level, const Rules& rules, const ShapedPoints& in, ShapedPoints& out) {
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        const std::uint32_t to = level.edges[e].odd;
        const TenPoints p = level.ten_points(e);
        const auto add_all = [&](const auto& points, const LatticeMasks::Matrix& m) {
            for (const std::uint32_t i : points) add(in.v[i], in.x[i], m, out.v[to], out.x[to]);
        };
        if (level.sharp(p.ends[0]) || level.sharp(p.ends[1])) {
            out.v[to] = (in.v[p.ends[0]] + in.v[p.ends[1]]) * 0.5;
        } else if (is_ordinary(level, e)) {
            add_all(p.ends, rules.regular.J);
            add_all(p.opp, rules.regular.K);
            add_all(p.wings, rules.regular.M);
            add_all(p.far, rules.regular.N);
        } else {
            add_all(p.ends, rules.J_3);
            add_all(p.opp, rules.K_3);
        }
    }
}

}  // namespace

ShapedPoints subdivide_once(const Level& level, const ShapedPoints& coarse, double s) {
    assert(coarse.v.size() == level.vertex_count && coarse.x.size() == level.vertex_count);
    const std::size_t count = level.vertex_count + level.edges.size();
    ShapedPoints fine{std::vector<Vec3>(count), std::vector<Vec3>(count)};
    const Rules rules(s);
    even(level, rules, coarse, fine);
    odd(level, rules, coarse, fine);
    return fine;
}

std::vector<Vec3> subdivide(const BaseMesh& base, std::span<const Vec3> positions, const SubdivideOptions& options,
                            std::span<const std::uint8_t> creases) {
    ShapedPoints points{{positions.begin(), positions.end()}, std::vector<Vec3>(positions.size())};
    for (unsigned j = 0; j < options.levels; ++j) {
        const Level level = make_level(base, j, creases);
        std::vector<std::uint32_t> ring;
        for (std::uint32_t i = 0; j == 0 && i < level.vertex_count; ++i) {
            shape_neighbours(level, i, ring);
            if (level.sharp(i) || ring.empty()) continue;
            Vec3 mean;
            for (const std::uint32_t r : ring) mean += points.v[r];
            points.x[i] = (points.v[i] - mean / double(ring.size())) * (options.shape / 4);
        }
        points = subdivide_once(level, points, options.s);
    }
    return points.v;
}

}  // namespace mvw
