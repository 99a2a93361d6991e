#include "codec/transform/stencils.h"

#include <cmath>
#include <numbers>

namespace mvw {

namespace {

void add(std::vector<Term>& out, std::span<const std::uint32_t> vertices, double position, double shape = 0) {
    if (position == 0 && shape == 0) return;
    for (const std::uint32_t v : vertices)
        if (v != kNone) out.push_back({v, position, shape});
}

void add_ten(std::vector<Term>& out, const TenPoints& p, const TenWeights& position, const TenWeights& shape) {
    add(out, p.ends, position.ends, shape.ends);
    add(out, p.opp, position.opp, shape.opp);
    add(out, p.wings, position.wings, shape.wings);
    add(out, p.far, position.far, shape.far);
}

/// 1/2 each end plus, where a curve passes through an end v, half of x(v) along it: with both, the 4-point rule.
void add_four_points(const Level& level, const TenPoints& p, std::vector<Term>& out) {
    add(out, p.ends, 1.0 / 2);
    for (const std::uint32_t v : p.ends)
        if (level.on_curve(v)) {
            out.push_back({v, 1.0 / 8, 0});
            add(out, level.curve_neighbours(v), -1.0 / 16);
        }
}

/// Ends of more edges take no part of Zorin's rule: with one spoke for each of its terms, a base's one hub would take
/// memory and time by the square of its valence.
constexpr std::uint32_t kMostOfZorin = 32;

/// Zorin's rule around one irregular end v with neighbours e_0 (the edge's other end), e_1 ... in turn.
void add_zorin(const Level& level, std::uint32_t half, double scale, std::vector<Term>& out) {
    const std::uint32_t v = level.from(half);
    const std::uint32_t n = level.valence[v];
    out.push_back({v, 0.75 * scale, 0});
    std::uint32_t h = half;
    for (std::uint32_t j = 0; j < n; ++j, h = level.twin[Level::prev(h)]) {
        const double turn = 2 * std::numbers::pi * j / n;
        double weight = (0.25 + std::cos(turn) + 0.5 * std::cos(2 * turn)) / n;
        if (n == 3) weight = j == 0 ? 5.0 / 12 : -1.0 / 12;
        if (n == 4) weight = j == 0 ? 3.0 / 8 : j == 2 ? -1.0 / 8 : 0;
        out.push_back({level.to(h), weight * scale, 0});
    }
}

void add_irregular(const Level& level, std::uint32_t edge, const TenPoints& p, PredictRule rule, double s,
                   std::vector<Term>& out) {
    if (rule == PredictRule::Butterfly) {
        const std::uint32_t h = level.edges[edge].half;
        if (level.valence[p.ends[0]] > kMostOfZorin || level.valence[p.ends[1]] > kMostOfZorin)
            return add(out, p.ends, 1.0 / 2);
        const bool first = !level.regular(p.ends[0]), second = !level.regular(p.ends[1]);
        const double scale = first && second ? 0.5 : 1.0;
        if (first) add_zorin(level, h, scale, out);
        if (second) add_zorin(level, level.twin[h], scale, out);
        return;
    }
    const double ends = 31.0 / 72 * (rule == PredictRule::SeededNormal ? 1.0 : s);
    const double shape = rule == PredictRule::Interp ? 0 : 1.0 / 4;
    add(out, p.ends, ends, shape);
    add(out, p.opp, 0.5 - ends, shape);
}

}  // namespace

PredictRule predict_rule(TransformKind kind) {
    switch (kind) {
        case TransformKind::Interp:
        case TransformKind::InterpLazy:
        case TransformKind::Vector:
            return PredictRule::Interp;
        case TransformKind::Loop:
        case TransformKind::LoopLazy:
            return PredictRule::Loop;
        case TransformKind::Butterfly:
        case TransformKind::ButterflyLazy:
            return PredictRule::Butterfly;
        case TransformKind::Seeded:
        case TransformKind::SeededLazy:
            return PredictRule::Seeded;
        case TransformKind::SeededNormal:
        case TransformKind::SeededNormalLazy:
            break;
    }
    return PredictRule::SeededNormal;
}

bool is_lazy(TransformKind kind) {
    return kind == TransformKind::InterpLazy || kind == TransformKind::LoopLazy ||
           kind == TransformKind::ButterflyLazy || kind == TransformKind::SeededLazy ||
           kind == TransformKind::SeededNormalLazy;
}

void predict_terms(const Level& level, std::uint32_t edge, PredictRule rule, double s, std::vector<Term>& out) {
    const TenPoints p = level.ten_points(edge);
    const bool seeded = rule == PredictRule::Seeded || rule == PredictRule::SeededNormal;
    if (level.edges[edge].sharp) {
        if (seeded || rule == PredictRule::Butterfly) return add_four_points(level, p, out);
        return add(out, p.ends, 1.0 / 2);
    }
    if (rule == PredictRule::Loop) return add_ten(out, p, kLoopPosition, {});
    if (level.sharp(p.ends[0]) || level.sharp(p.ends[1])) {
        for (const std::uint32_t v : p.ends) out.push_back({v, 1.0 / 2, seeded && !level.sharp(v) ? 1.0 : 0.0});
        return;
    }
    if (!level.regular(p.ends[0]) || !level.regular(p.ends[1])) return add_irregular(level, edge, p, rule, s, out);
    add_ten(out, p, rule == PredictRule::Butterfly ? kButterflyPosition : kInterpPosition,
            seeded ? kInterpShape : TenWeights{});
}

void shape_neighbours(const Level& level, std::uint32_t v, std::vector<std::uint32_t>& out) {
    out.clear();
    if (level.sharp(v) && !level.on_curve(v)) return;
    for (const std::uint32_t e : level.edges_at(v))
        if (!level.sharp(v) || level.edges[e].sharp) out.push_back(level.other_end(e, v));
}

LoopEven loop_even(const Level& level, std::uint32_t v) {
    return loop_even(level.valence[v], level.sharp(v), level.on_curve(v));
}

LoopEven loop_even(std::size_t valence, bool sharp, bool on_curve) {
    if (sharp) return on_curve ? LoopEven{1.0 / 2, 1.0 / 4} : LoopEven{1, 0};
    const auto n = static_cast<double>(valence);
    const double c = 3.0 / 8 + std::cos(2 * std::numbers::pi / n) / 4;
    const double b = 8.0 / 5 * (5.0 / 8 - c * c) / n;
    return {1 - n * b, b};
}

void loop_edges(const Level& level, std::uint32_t v, std::vector<std::uint32_t>& out) {
    out.clear();
    if (level.sharp(v) && !level.on_curve(v)) return;
    for (const std::uint32_t e : level.edges_at(v))
        if (!level.sharp(v) || level.edges[e].sharp) out.push_back(e);
}

}  // namespace mvw
