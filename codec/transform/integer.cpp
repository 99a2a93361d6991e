#include "codec/transform/integer.h"

#include <cassert>
#include <cmath>
#include <vector>

#include "codec/transform/stencils.h"

namespace mvw {

namespace {

constexpr double kOne = 65536;  // weights are multiples of its inverse

std::uint32_t added(std::int32_t a, std::int64_t b) {
    return static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b);
}

/// Calls take(odd vertex, prediction) for each edge of one level.
template <typename Take>
void predict(const Level& level, std::span<const IntegerPoint> points, const Take& take) {
    std::vector<Term> terms;
    std::vector<std::int64_t> weights;
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        terms.clear();
        weights.clear();
        predict_terms(level, e, PredictRule::Butterfly, TransformOptions{}.s, terms);
        // Rounded weights must still sum to 1, or the prediction would depend on where the origin is.
        std::int64_t rest = static_cast<std::int64_t>(kOne);
        for (const Term& t : terms) {
            weights.push_back(std::llround(t.position * kOne));
            rest -= weights.back();
        }
        weights[0] += rest;
        std::array<std::int64_t, 3> sum{};
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t t = 0; t < terms.size(); ++t) sum[k] += weights[t] * points[terms[t].vertex][k];
            sum[k] = (sum[k] + 32768) >> 16;
        }
        take(level.edges[e].odd, sum);
    }
}

}  // namespace

void analyze_integers(const BaseMesh& base, unsigned levels, std::span<const std::uint8_t> creases,
                      std::span<IntegerPoint> points) {
    assert(points.size() == vertices_at_level(base, levels));
    for (unsigned level = levels; level-- > 0;)  // finest first: predictions are from positions
        predict(make_level(base, level, creases), points, [&](std::uint32_t odd, const auto& prediction) {
            for (std::size_t k = 0; k < 3; ++k)
                points[odd][k] = static_cast<std::int32_t>(added(points[odd][k], -prediction[k]));
        });
}

void synthesize_integers(const BaseMesh& base, unsigned levels, std::span<const std::uint8_t> creases,
                         std::span<IntegerPoint> points) {
    assert(points.size() == vertices_at_level(base, levels));
    for (unsigned level = 0; level < levels; ++level)
        predict(make_level(base, level, creases), points, [&](std::uint32_t odd, const auto& prediction) {
            for (std::size_t k = 0; k < 3; ++k)
                points[odd][k] = static_cast<std::int32_t>(added(points[odd][k], prediction[k]));
        });
}

}  // namespace mvw
