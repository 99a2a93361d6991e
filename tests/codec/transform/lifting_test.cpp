#include "codec/transform/lifting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "codec/transform/transform.h"
#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

void expect_weights(const TenWeights& found, const TenWeights& wanted, double tolerance) {
    EXPECT_NEAR(found.ends, wanted.ends, tolerance);
    EXPECT_NEAR(found.opp, wanted.opp, tolerance);
    EXPECT_NEAR(found.wings, wanted.wings, tolerance);
    EXPECT_NEAR(found.far, wanted.far, tolerance);
}

TEST(OrdinaryLifting, FollowsFromTheMasks) {
    expect_weights(lattice_weights(interpolatory_masks(), 7), {-0.17781, -0.00169, 0.02462, 0.02488}, 1e-5);
    expect_weights(lattice_weights(interpolatory_masks(true), 7), {-0.17785, -0.00184, 0.02495, 0.02482}, 1e-5);
    expect_weights(lattice_weights(scalar_masks(kInterpPosition), 7), {-0.19943, 0.00361, 0.03489, 0.03200}, 1e-5);
    expect_weights(lattice_weights(scalar_masks(kInterpPosition), 1), {-0.18296, 0.00293, 0.02617, 0.02483}, 1e-5);
}

TEST(OrdinaryLifting, BoxSplineServesTheVectorTransform) {
    expect_weights(lattice_weights(loop_masks(), 12), {-0.26026, 0.01737, 0.06022, 0.04705}, 1e-5);
}

TEST(OrdinaryLifting, PublishedTableIsACoarserQuadratureOfTheSame) {
    expect_weights(lattice_weights(interpolatory_masks(), 7), kTable1, 0.0011);
    TransformOptions options{.kind = TransformKind::Interp, .table1_weights = true};
    expect_weights(ordinary_lifting(options), kTable1, 0);
}

TEST(OrdinaryLifting, WaveletsAreOrthogonalToTheTemplate) {
    for (const unsigned levels : {1u, 7u}) {
        const LatticeMasks masks = interpolatory_masks();
        EXPECT_LT(lattice_residual(masks, levels, lattice_weights(masks, levels)), 1e-10);
        EXPECT_GT(lattice_residual(masks, levels, kTable1), 1e-5);
    }
}

/// The edge of a level between two vertices.
std::uint32_t edge_between(const Level& level, std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t e : level.edges_at(a))
        if (level.other_end(e, a) == b) return e;
    return kNone;
}

std::vector<double> weights_of(const DiscreteLifting& lifting, std::uint32_t edge, bool four) {
    std::vector<LiftTerm> terms;
    lifting.weights(edge, four, terms);
    std::vector<double> weights;
    weights.reserve(terms.size());
    for (const LiftTerm& t : terms) weights.push_back(t.weight);
    return weights;
}

TEST(DiscreteLifting, GivesBertramsWeightsForLoop) {
    struct Row {
        std::uint32_t n;
        double end_n, end_6, opp;
    };
    for (const Row& row : {Row{6, -0.284905, -0.284905, 0.071591}, Row{5, -0.371945, -0.272331, 0.093146},
                           Row{7, -0.232761, -0.292500, 0.058571}, Row{8, -0.198097, -0.297558, 0.049901},
                           Row{3, -0.850101, -0.179627, 0.153990}, Row{4, -0.537972, -0.247424, 0.131160}}) {
        const BaseMesh base = test::fan(row.n);
        const Level level = make_level(base, 3, {});
        const DiscreteLifting lifting(level, PredictRule::Loop, 1);
        const std::uint32_t edge = edge_between(level, 0, vertex_index(base, 0, 3, 1, 0));
        std::vector<double> w = weights_of(lifting, edge, true);
        ASSERT_EQ(w.size(), 4u);
        if (level.from(level.edges[edge].half) != 0) std::swap(w[0], w[1]);
        EXPECT_NEAR(w[0], row.end_n, 1e-6) << row.n;
        EXPECT_NEAR(w[1], row.end_6, 1e-6) << row.n;
        EXPECT_NEAR(w[2], row.opp, 1e-6) << row.n;
        EXPECT_NEAR(w[3], row.opp, 1e-6) << row.n;
    }
}

TEST(DiscreteLifting, TreatsLoopsBoundaryAsACubicSpline) {
    const BaseMesh base = test::one_triangle();
    const Level level = make_level(base, 4, {});
    const DiscreteLifting lifting(level, PredictRule::Loop, 1);
    const std::uint32_t edge = edge_between(level, vertex_index(base, 0, 4, 7, 0), vertex_index(base, 0, 4, 8, 0));
    const std::vector<double> w = weights_of(lifting, edge, false);
    ASSERT_EQ(w.size(), 4u);
    for (const std::size_t i : {0u, 1u}) EXPECT_NEAR(w[i], -0.525336, 1e-6);
    for (const std::size_t i : {2u, 3u}) EXPECT_NEAR(w[i], 0.189068, 1e-6);
}

TEST(DiscreteLifting, SolvesTheMidpointRuleOnACurve) {
    const BaseMesh base = test::one_triangle();
    const Level level = make_level(base, 4, {});
    const DiscreteLifting lifting(level, PredictRule::Interp, 1);
    const std::uint32_t a = vertex_index(base, 0, 4, 7, 0), b = vertex_index(base, 0, 4, 8, 0);
    std::vector<LiftTerm> terms;
    lifting.weights(edge_between(level, a, b), {a, b}, terms);
    EXPECT_NEAR(terms[0].weight, -2.0 / 7, 1e-14);
    EXPECT_NEAR(terms[1].weight, -2.0 / 7, 1e-14);
}

// Every edge of this sheet touches its boundary or both ends' edges use the midpoint rule.
TEST(DiscreteLifting, SolvesTheMidpointRuleOnASurface) {
    const BaseMesh base = test::fan(6);
    const Level level = make_level(base, 0, {});
    const DiscreteLifting lifting(level, PredictRule::Interp, 1);
    std::vector<LiftTerm> terms;
    lifting.weights(edge_between(level, 0, 1), {0, 1}, terms);
    // [1 + n0/4, 1/4; 1/4, 1 + n1/4] w = (-1/2, -1/2) with n0 = 6, n1 = 3.
    const double determinant = 2.5 * 1.75 - 0.0625;
    EXPECT_NEAR(terms[0].weight, -(0.5 * 1.75 - 0.125) / determinant, 1e-14);
    EXPECT_NEAR(terms[1].weight, -(0.5 * 2.5 - 0.125) / determinant, 1e-14);
}

/// Two hubs, n spokes each to a common rim: vertices 0 and 1, then the rim.
BaseMesh bipyramid(std::uint32_t n) {
    std::vector<Face> faces;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 + i, b = 2 + (i + 1) % n;
        faces.push_back({0, a, b});
        faces.push_back({1, b, a});
    }
    return BaseMesh::create(n + 2, std::move(faces)).value();
}

/// phi_v on the next level, vertex by vertex, by a rule that keeps coarse vertices where they are.
std::vector<double> response_of(const Level& level, PredictRule rule, std::uint32_t v) {
    std::vector<double> phi(level.vertex_count + level.edges.size());
    phi[v] = 1;
    std::vector<Term> terms;
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        terms.clear();
        predict_terms(level, e, rule, 1, terms);
        for (const Term& t : terms)
            if (t.vertex == v) phi[level.edges[e].odd] += t.position;
    }
    return phi;
}

// A rim edge has both hubs in its template, a spoke one; by Zorin's rule the rim sees all of a hub's ring.
TEST(DiscreteLifting, WaveletsBesideHubsAreOrthogonalToTheTemplate) {
    for (const auto& [rule, spokes] : {std::pair{PredictRule::Interp, 300u}, {PredictRule::Butterfly, 32u}})
        for (const unsigned j : {0u, 1u}) {
            const BaseMesh base = bipyramid(spokes);
            const Level level = make_level(base, j, {});
            const DiscreteLifting lifting(level, rule, 1);
            const auto point = [&](std::uint32_t i) { return vertex_index(base, 2 * i, j, 0, 1); };  // next to vertex 0
            for (const std::uint32_t edge : {edge_between(level, 0, point(0)), edge_between(level, 0, point(7)),
                                             edge_between(level, point(3), point(4))}) {
                ASSERT_NE(edge, kNone);
                std::vector<LiftTerm> terms;
                lifting.weights(edge, false, terms);
                std::vector<double> wavelet(level.vertex_count + level.edges.size());
                wavelet[level.edges[edge].odd] = 1;
                for (const LiftTerm& t : terms) {
                    const std::vector<double> phi = response_of(level, rule, t.vertex);
                    for (std::size_t i = 0; i < phi.size(); ++i) wavelet[i] += t.weight * phi[i];
                }
                for (const LiftTerm& t : terms) {
                    const std::vector<double> phi = response_of(level, rule, t.vertex);
                    EXPECT_NEAR(std::inner_product(phi.begin(), phi.end(), wavelet.begin(), 0.0), 0, 1e-9) << t.vertex;
                }
            }
        }
}

// What a hostile base may ask for: products of all that see a hub would take its valence cubed.
TEST(DiscreteLifting, TakesHubsOfAThousandSpokes) {
    const BaseMesh base = bipyramid(1000);
    const Level level = make_level(base, 0, {});
    for (const PredictRule rule : {PredictRule::Interp, PredictRule::Loop, PredictRule::Butterfly}) {
        const DiscreteLifting lifting(level, rule, 1);
        std::vector<LiftTerm> terms;
        for (std::uint32_t e = 0; e < level.edges.size(); ++e) lifting.weights(e, false, terms);
        EXPECT_TRUE(std::ranges::all_of(terms, [](const LiftTerm& t) { return std::isfinite(t.weight); }));
    }
}

TEST(PredictTerms, ButterflySumsToOneAndTakesTheMidpointAtHubs) {
    for (const std::uint32_t spokes : {5u, 32u, 33u, 1000u}) {
        const Level level = make_level(bipyramid(spokes), 0, {});
        for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
            std::vector<Term> terms;
            predict_terms(level, e, PredictRule::Butterfly, 1, terms);
            double sum = 0;
            for (const Term& t : terms) sum += t.position;
            ASSERT_NEAR(sum, 1, 1e-12) << spokes << " spokes, edge " << e;
            const std::uint32_t h = level.edges[e].half;
            const bool at_hub = level.from(h) < 2 || level.to(h) < 2;
            EXPECT_TRUE(!at_hub || (terms.size() == 2) == (spokes > 32)) << spokes << " spokes, edge " << e;
        }
    }
}

// Tables must be linear in the base, whatever its valences are.
TEST(PredictTerms, HubsTakeMemoryInProportionToTheirSpokes) {
    for (unsigned kind = 0; kind <= static_cast<unsigned>(TransformKind::SeededNormalLazy); ++kind) {
        TransformOptions options;
        options.kind = TransformKind{static_cast<std::uint8_t>(kind)};
        const auto bytes = [&](std::uint32_t spokes) {
            return double(PatchTransform(bipyramid(spokes), 3, options, {}, 1).memory_bytes());
        };
        EXPECT_LT(bytes(1600), 2.5 * bytes(800)) << kind;
    }
}

}  // namespace
}  // namespace mvw
