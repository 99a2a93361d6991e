#include "codec/transform/patch/listed_stencils.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>

#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

/// A stencil as sums by vertex: weights of positions, of shape components, of lifting.
using Weights = std::map<std::tuple<std::uint32_t, int, int>, std::array<double, 3>>;
using EdgeName = std::tuple<std::uint32_t, int, int, int>;

std::map<EdgeName, Weights> by_edge(const ListedStencils& stencils, const GridTopology& topology, int n) {
    std::map<EdgeName, Weights> result;
    for (std::size_t e = 0; e < stencils.edges.size(); ++e) {
        const GridEdge edge = topology.owner(stencils.edges[e].edge, n);
        Weights& weights = result[{edge.face, static_cast<int>(edge.plane), edge.i, edge.k}];
        EXPECT_TRUE(weights.empty()) << "listed twice";
        const auto at = [&](const GridVertex& name) -> std::array<double, 3>& {
            const GridVertex v = topology.owner(name, n);
            return weights[{v.face, v.i, v.k}];
        };
        for (const auto& term : stencils.terms_of(e)) {
            at(term.vertex)[0] += term.position;
            at(term.vertex)[1] += term.shape;
        }
        for (const auto& lift : stencils.lifts_of(e)) at(lift.vertex)[2] += lift.weight;
    }
    return result;
}

/// A sphere of valences 3 to 8 and 19 beside each other: a bipyramid, three in five of its faces split in three.
BaseMesh uneven_sphere() {
    const BaseMesh plain = test::bipyramid(12);
    std::vector<Face> faces;
    std::uint32_t vertices = plain.vertex_count();
    for (std::uint32_t f = 0; f < plain.face_count(); ++f) {
        const auto& [a, b, c] = plain.faces()[f];
        if (f % 5 < 2) {
            faces.push_back({a, b, c});
            continue;
        }
        faces.push_back({a, b, vertices});
        faces.push_back({b, c, vertices});
        faces.push_back({c, a, vertices++});
    }
    return test::make_base(vertices, std::move(faces));
}

/// Two tetrahedra that share vertex 0: a vertex of six edges in two fans.
BaseMesh two_fans() {
    return test::make_base(7, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 5, 4}, {0, 4, 6}, {4, 5, 6}, {5, 0, 6}});
}

/// Stencils carried to a level are those that the level's whole connectivity gives.
void expect_carried(const test::NamedBase& b, const TransformOptions& options, unsigned level) {
    SCOPED_TRACE(b.name + ", transform " + std::to_string(static_cast<int>(options.kind)) + ", level " +
                 std::to_string(level));
    const GridTopology topology(b.base);
    CarriedStencils carried(topology, options, b.creases);
    const auto found =
        by_edge(level == kSpokeLevel ? carried.at_spoke_level() : carried.at_level(level), topology, 1 << level);
    const auto wanted = by_edge(explicit_stencils(b.base, level, options, b.creases), topology, 1 << level);
    ASSERT_EQ(found.size(), wanted.size());
    for (const auto& [edge, weights] : wanted) {
        const auto same = found.find(edge);
        ASSERT_NE(same, found.end());
        ASSERT_EQ(same->second.size(), weights.size());
        for (const auto& [vertex, values] : weights) {
            const auto other = same->second.find(vertex);
            ASSERT_NE(other, same->second.end());
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(other->second[k], values[k], 1e-12);
        }
    }
}

TEST(CarriedStencils, AreThoseOfTheWholeLevel) {
    std::vector<test::NamedBase> bases = test::all_bases();
    bases.push_back({"uneven sphere", uneven_sphere(), {}});
    bases.push_back({"two fans", two_fans(), {}});
    test::NamedBase mixed{"large torus with a crease", test::grid(8, 8, true), {}};
    mixed.creases.assign(mixed.base.edge_count(), 0);
    mixed.creases[5] = 1;
    bases.push_back(mixed);
    for (const test::NamedBase& b : bases)
        for (unsigned kind = 0; kind < kTransformCount; ++kind)
            for (unsigned level = kSpokeLevel; level <= kFanLevel; ++level) {
                if (level == kFanLevel && b.name == "two fans") continue;  // there each fan counts alone
                expect_carried(b, {.kind = static_cast<TransformKind>(kind)}, level);
            }
    expect_carried(bases.back(), {.kind = TransformKind::Interp, .s = 0.8}, kSpokeLevel);
    expect_carried(bases.back(), {.kind = TransformKind::Loop, .loop_template = 4}, kSpokeLevel);
}

}  // namespace
}  // namespace mvw
