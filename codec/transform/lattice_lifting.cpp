// Inner products on the regular lattice, without sampling it: with Phi_m the scheme's response to one vertex after m
// subdivisions (a 2x2 matrix for each lattice point) and C_m(k) = 4^-m sum over x of Phi_m(x) D Phi_m(x - 2^m k)^T,
// D = diag(1, 0), the refinement equation gives C_m+1(k) = 1/4 sum over y, z of P(y) C_m(2k + z - y) P(z)^T: the same
// sums as over the lattice of level m + 1, from a table of a few hundred entries.
#include <cmath>

#include "codec/transform/dense_solve.h"
#include "codec/transform/lifting.h"

namespace mvw {

namespace {

using Matrix = LatticeMasks::Matrix;

struct Offset {
    int i, k;
    friend constexpr Offset operator+(Offset a, Offset b) { return {a.i + b.i, a.k + b.k}; }
    friend constexpr Offset operator-(Offset a, Offset b) { return {a.i - b.i, a.k - b.k}; }
    friend constexpr Offset operator*(int s, Offset a) { return {s * a.i, s * a.k}; }
};
/// A sixth of a turn: (1,0) -> (0,1) -> (-1,1) ...
constexpr Offset turned(Offset a) {
    return {-a.k, a.i + a.k};
}

struct Tap {
    Offset at;
    Matrix weight;
};

/// P(y): what a coarse vertex at 0 gives to the fine point y.
std::vector<Tap> taps_of(const LatticeMasks& m) {
    std::vector<Tap> taps{{{0, 0}, m.G}};
    Offset u{1, 0};
    for (unsigned turn = 0; turn < 6; ++turn, u = turned(u)) {
        const Offset v = turned(u);
        taps.push_back({2 * u, m.L});
        taps.push_back({u, m.J});          // an edge that starts here
        taps.push_back({u + v, m.K});      // the edge opposite
        taps.push_back({3 * u, m.N});      // an edge one further on this line
        taps.push_back({2 * u + v, m.M});  // two edges have this vertex as a wing
        taps.push_back({u + 2 * v, m.M});
    }
    return taps;
}

/// A 2x2 matrix for each offset within a radius; zero outside.
class Table {
 public:
    explicit Table(int radius) : radius_(radius), width_(2 * radius + 1), data_(std::size_t(width_) * width_) {}
    Matrix& at(Offset a) { return data_[std::size_t(a.i + radius_) * width_ + std::size_t(a.k + radius_)]; }
    [[nodiscard]] Matrix get(Offset a) const {
        if (std::abs(a.i) > radius_ || std::abs(a.k) > radius_) return {};
        return data_[std::size_t(a.i + radius_) * width_ + std::size_t(a.k + radius_)];
    }

 private:
    int radius_, width_;
    std::vector<Matrix> data_;
};

void add_product(Matrix& sum, const Matrix& a, const Matrix& b, double scale) {
    sum[0] += scale * (a[0] * b[0] + a[1] * b[2]);
    sum[1] += scale * (a[0] * b[1] + a[1] * b[3]);
    sum[2] += scale * (a[2] * b[0] + a[3] * b[2]);
    sum[3] += scale * (a[2] * b[1] + a[3] * b[3]);
}
constexpr Matrix transposed(const Matrix& a) {
    return {a[0], a[2], a[1], a[3]};
}

// Two responses of support 3 overlap up to offset 6; P reaches 3 further.
constexpr int kRadius = 6, kFineRadius = kRadius + 3;

/// sum over y of P(y) C(j - y), for each fine offset j: the product of a coarse and a fine response.
Table half_refined(const std::vector<Tap>& taps, const Table& C) {
    Table mixed(kFineRadius);
    for (const Tap& tap : taps)
        for (int i = -kRadius; i <= kRadius; ++i)
            for (int k = -kRadius; k <= kRadius; ++k)
                add_product(mixed.at(Offset{i, k} + tap.at), tap.weight, C.get({i, k}), 1);
    return mixed;
}

Table refined(const std::vector<Tap>& taps, const Table& C) {
    const Table mixed = half_refined(taps, C);
    Table next(kRadius);
    for (int i = -kRadius; i <= kRadius; ++i)
        for (int k = -kRadius; k <= kRadius; ++k)
            for (const Tap& tap : taps)
                add_product(next.at({i, k}), mixed.get(2 * Offset{i, k} + tap.at), transposed(tap.weight), 0.25);
    return next;
}

/// The ten points around the edge from (0,0) to (1,0), by class: ends, opp, wings, far.
constexpr std::array<Offset, 10> kTen{
    {{0, 0}, {1, 0}, {0, 1}, {1, -1}, {-1, 1}, {1, 1}, {0, -1}, {2, -1}, {-1, 0}, {2, 0}}};
constexpr std::array<std::size_t, 5> kClassStart{0, 2, 4, 8, 10};
constexpr Offset kEdgePoint{1, 0};  // of the fine lattice

struct LatticeSystem {
    std::vector<double> gram, edge;  // <phi_i, phi_k>; <phi_e, phi_i>
};

LatticeSystem lattice_system(const LatticeMasks& masks, unsigned levels, double end_share) {
    const std::vector<Tap> taps = taps_of(masks);
    Table fine(kRadius), coarse(kRadius);
    fine.at({0, 0})[0] = 1;
    for (unsigned m = 1; m < levels; ++m) fine = refined(taps, fine);
    coarse = refined(taps, fine);
    const Table mixed = half_refined(taps, fine);
    LatticeSystem system{std::vector<double>(100), std::vector<double>(10)};
    for (std::size_t a = 0; a < 10; ++a) {
        for (std::size_t b = 0; b < 10; ++b) system.gram[10 * a + b] = coarse.get(kTen[b] - kTen[a])[0];
        const auto fine_product = [&](Offset at) { return 0.25 * mixed.get(at - 2 * kTen[a])[0]; };
        system.edge[a] = fine_product(kEdgePoint) + end_share * (fine_product({0, 0}) + fine_product({2, 0}));
    }
    return system;
}

}  // namespace

LatticeMasks interpolatory_masks(bool printed_sign) {
    const auto& p = kInterpPosition;
    const auto& x = kInterpShape;
    return {{1, 3.0 / 8, 0, -1.0 / 2},
            {0, -1.0 / 16, 0, -1.0 / 8},
            {p.ends, -1.0 / 36, x.ends, 7.0 / 36},
            {p.opp, 1.0 / 72, x.opp, 1.0 / 36},
            {p.wings, 1.0 / 288, printed_sign ? -x.wings : x.wings, 1.0 / 144},
            {p.far, 1.0 / 144, x.far, 1.0 / 72}};
}

LatticeMasks scalar_masks(const TenWeights& p) {
    return {{1}, {0}, {p.ends}, {p.opp}, {p.wings}, {p.far}};
}

LatticeMasks loop_masks() {
    return {{5.0 / 8}, {1.0 / 16}, {kLoopPosition.ends}, {kLoopPosition.opp}, {0}, {0}};
}

TenWeights lattice_weights(const LatticeMasks& masks, unsigned levels, double end_share, bool four) {
    const LatticeSystem system = lattice_system(masks, levels, end_share);
    const std::size_t n = four ? 4 : 10;
    std::vector<double> A(n * n), w(n);
    for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = 0; b < n; ++b) A[n * a + b] = system.gram[10 * a + b];
        w[a] = -system.edge[a];
    }
    solve_positive_definite(A, w);
    // Members of a class agree by symmetry up to rounding.
    return {w[kClassStart[0]], w[kClassStart[1]], four ? 0 : w[kClassStart[2]], four ? 0 : w[kClassStart[3]]};
}

double lattice_residual(const LatticeMasks& masks, unsigned levels, const TenWeights& weights) {
    const LatticeSystem system = lattice_system(masks, levels, 0);
    const std::array<double, 4> by_class{weights.ends, weights.opp, weights.wings, weights.far};
    double worst = 0;
    for (std::size_t a = 0; a < 10; ++a) {
        double sum = system.edge[a];
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t b = kClassStart[c]; b < kClassStart[c + 1]; ++b)
                sum += by_class[c] * system.gram[10 * a + b];
        worst = std::max(worst, std::abs(sum) / system.gram[11 * a]);
    }
    return worst;
}

namespace {

TenWeights solved_lifting(const TransformOptions& options) {
    switch (options.kind) {
        case TransformKind::InterpLazy:
        case TransformKind::LoopLazy:
        case TransformKind::ButterflyLazy:
        case TransformKind::SeededLazy:
        case TransformKind::SeededNormalLazy:
            return {};
        case TransformKind::Vector:
            return lattice_weights(loop_masks(), 12);
        case TransformKind::Loop:
            return lattice_weights(loop_masks(), 1, 1.0 / 10, options.loop_template == 4);
        case TransformKind::Butterfly:
            return lattice_weights(scalar_masks(kButterflyPosition), 1);
        case TransformKind::Interp:
        case TransformKind::Seeded:
        case TransformKind::SeededNormal:
            break;
    }
    return lattice_weights(interpolatory_masks(), 7);
}

}  // namespace

TenWeights ordinary_lifting(const TransformOptions& options) {
    const bool interpolatory = options.kind == TransformKind::Interp || options.kind == TransformKind::Seeded ||
                               options.kind == TransformKind::SeededNormal;
    if (!interpolatory) return solved_lifting(options);
    if (options.table1_weights) return kTable1;
    static const TenWeights solved = solved_lifting({});  // some milliseconds, and every decoder asks
    return solved;
}

}  // namespace mvw
