#include "codec/entropy/mesh_model.h"

#include <algorithm>
#include <bit>

#include "codec/entropy/mesh_priors.h"

namespace mvw {

namespace {

using Wide = std::array<std::int64_t, 3>;

constexpr unsigned kMostHops = 24;
constexpr unsigned kFeatureBits = 12;  // of the positions that contexts are made of

Wide operator-(const Wide& a, const Wide& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Wide operator+(const Wide& a, const Wide& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
std::int64_t dot(const Wide& a, const Wide& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Wide cross(const Wide& a, const Wide& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The angle from `from` counter-clockwise to `to`, seen against `normal`.
std::size_t angle_class(const Wide& from, const Wide& to, const Wide& normal) {
    const std::int64_t c = dot(from, to), aa = dot(from, from), bb = dot(to, to);
    const bool over_half = dot(cross(from, to), normal) < 0;
    // Cosine squared in 1/16, with the cosine's sign.
    const std::int64_t whole = std::max<std::int64_t>(aa * bb, 1);
    const auto square = static_cast<int>(c * c * 16 / whole) * (c < 0 ? -1 : 1);
    if (over_half) return square < -4 ? 8 : 9;
    if (square >= 14) return 0;  // to 21 degrees
    if (square >= 9) return 1;   // 41
    if (square >= 4) return 2;   // 60
    if (square >= 1) return 3;   // 76
    if (square > -1) return 4;   // 104
    if (square > -4) return 5;   // 120
    if (square > -10) return 6;  // 142
    return 7;
}

/// a over b, both squared lengths.
std::size_t length_class(std::int64_t a, std::int64_t b) {
    if (2 * a < b) return 0;
    if (a < b) return 1;
    if (a < 2 * b) return 2;
    return a < 4 * b ? 3 : 4;
}

}  // namespace

GateView::GateView(const MeshGrowth& growth, const std::vector<GridPoint>& positions, unsigned bits, std::uint32_t gate)
    : positions_(positions) {
    const MeshGrowth::Node& start = growth.node(gate);
    const MeshGrowth::Node& end = growth.node(start.next);
    const MeshGrowth::Node& before = growth.node(start.previous);
    around_ = {start.vertex, end.vertex, growth.inner(gate), before.vertex, growth.node(end.next).vertex};
    const unsigned shift = bits > kFeatureBits ? bits - kFeatureBits : 0;
    const auto at = [&](std::uint32_t v) {
        const GridPoint& p = positions[v];
        return Wide{p[0] >> shift, p[1] >> shift, p[2] >> shift};
    };
    const auto normal_at = [&](std::uint32_t n) {
        const Wide a = at(growth.node(n).vertex), b = at(growth.node(growth.next(n)).vertex);
        return cross(at(growth.inner(n)) - a, b - a);  // the triangle runs from b to a
    };
    const Wide a = at(around_[0]), b = at(around_[1]);
    const Wide here = normal_at(gate);
    gap_at_start_ = angle_class(b - a, at(around_[3]) - a, here + normal_at(start.previous));
    gap_at_end_ = angle_class(at(around_[4]) - b, a - b, here + normal_at(start.next));
    const std::int64_t length = dot(b - a, b - a);
    closing_after_ = length_class(dot(at(around_[4]) - a, at(around_[4]) - a), length);
    closing_before_ = length_class(dot(at(around_[3]) - b, at(around_[3]) - b), length);
    const auto squared = [&](std::uint32_t v, std::uint32_t w) {
        std::uint64_t sum = 0;
        for (unsigned k = 0; k < 3; ++k) {
            const std::int64_t d = std::int64_t{positions[v][k]} - positions[w][k];
            sum += static_cast<std::uint64_t>(d * d);
        }
        return sum;
    };
    const std::uint64_t square = squared(around_[0], around_[1]);
    const std::uint64_t mean = (2 * square + squared(around_[0], around_[2]) + squared(around_[1], around_[2]) +
                                squared(around_[0], around_[3]) + squared(around_[1], around_[4])) /
                               6;
    scale_ = std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(mean)), MeshModel::kScales - 1);
    normal_ = here;
    for (unsigned k = 1; k < 3; ++k)
        if (std::abs(normal_[k]) > std::abs(normal_[axis_])) axis_ = k;
    predict();
    find_nearest(growth, gate, square);
}

void GateView::find_nearest(const MeshGrowth& growth, std::uint32_t gate, std::uint64_t length) {
    const GridPoint& expected = prediction_;
    std::uint64_t least = ~std::uint64_t{0};
    const auto look = [&](std::uint32_t n) {
        std::uint64_t square = 0;
        for (unsigned k = 0; k < 3; ++k) {
            const std::int64_t d = std::int64_t{positions_[growth.node(n).vertex][k]} - expected[k];
            square += static_cast<std::uint64_t>(d * d);
        }
        if (square < least) least = square, nearest_ = n;
    };
    const std::uint32_t end = growth.next(gate);
    std::uint32_t ahead = growth.next(growth.next(end)), behind = growth.previous(growth.previous(gate));
    for (unsigned hops = 0; hops < kMostHops; ++hops) {
        if (ahead == growth.previous(gate) || ahead == gate) break;  // all round
        look(ahead);
        ahead = growth.next(ahead);
        if (behind == end || behind == growth.next(end)) break;
        look(behind);
        behind = growth.previous(behind);
    }
    const std::uint64_t parts = least == ~std::uint64_t{0}
                                    ? 1000
                                    : 16 * std::min(least, std::uint64_t{1} << 58) / std::max<std::uint64_t>(length, 1);
    touch_ = parts < 1 ? 0 : parts < 4 ? 1 : parts < 9 ? 2 : parts < 16 ? 3 : parts < 32 ? 4 : 5;
}

void GateView::predict() {
    const std::array<std::int8_t, 4>& weights = kMeshPrediction[prediction_class()];
    for (unsigned k = 0; k < 3; ++k) {
        const auto x = [&](unsigned n) { return 2 * std::int64_t{positions_[around_[n]][k]}; };
        const std::int64_t middle = (x(0) + x(1)) / 2;
        const std::int64_t sum = 64 * middle + weights[0] * (x(0) - middle) + weights[1] * (x(2) - middle) +
                                 weights[2] * (x(3) - middle) + weights[3] * (x(4) - middle);
        prediction_[k] = static_cast<std::int32_t>((sum + 64) >> 7);  // rounded to nearest, halves up
    }
}

std::int64_t GateView::in_plane(std::int64_t u, std::int64_t v) const {
    const std::int64_t n = normal_[axis_];
    if (n == 0) return 0;
    const std::int64_t sum = -(normal_[(axis_ + 1) % 3] * u + normal_[(axis_ + 2) % 3] * v);
    // Rounded to nearest, halves up.
    const std::int64_t top = 2 * sum * (n < 0 ? -1 : 1) + std::abs(n), below = 2 * std::abs(n);
    return top >= 0 ? top / below : -((-top + below - 1) / below);
}

MeshModel::MeshModel() : MeshModel(kTrainedMeshLogits, kTrainedMeshWeights) {}

MeshModel::MeshModel(const std::array<std::int8_t, kBits>& logits,
                     const std::array<std::int8_t, 2 * kWeights>& mixing) {
    for (std::size_t k = 0; k < kBits; ++k) bits[k] = AdaptiveBit(logits[k]);
    for (std::size_t k = 0; k < kWeights; ++k) weights[k].weight = {mixing[2 * k] * 1024, mixing[2 * k + 1] * 1024};
}

}  // namespace mvw
