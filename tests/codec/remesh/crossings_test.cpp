#include "codec/remesh/crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "codec/remesh/self_parameterization.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

using Triangle = std::array<Vec3, 3>;

TEST(TrianglesCross, WhereAnEdgeOfEitherPiercesTheOther) {
    const Triangle flat{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
    const Triangle upright{{{1, 1, -1}, {1, 1, 1}, {9, 9, 0}}};
    EXPECT_TRUE(triangles_cross(flat, upright));
    EXPECT_TRUE(triangles_cross(upright, flat));
    const Triangle needle{{{-1, 1, 1}, {-1, 1, -1}, {9, 1, 0}}};  // leaves through an edge
    EXPECT_TRUE(triangles_cross(flat, needle));
    EXPECT_TRUE(triangles_cross(needle, flat));
}

TEST(TrianglesCross, NotBesideAboveOrInOnePlane) {
    const Triangle flat{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
    EXPECT_FALSE(triangles_cross(flat, {{{3, 3, -1}, {3, 3, 1}, {9, 9, 0}}}));
    EXPECT_FALSE(triangles_cross(flat, {{{1, 1, 0.1}, {1, 1, 1}, {9, 9, 1}}}));
    EXPECT_FALSE(triangles_cross(flat, {{{1, 1, 0}, {5, 1, 0}, {1, 5, 0}}}));
}

/// Of all pairs of faces without a common vertex.
std::size_t crossing_pairs(const std::vector<Face>& faces, const std::vector<Vec3>& positions) {
    const auto corners = [&](const Face& f) { return Triangle{positions[f[0]], positions[f[1]], positions[f[2]]}; };
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) {
            bool shared = false;
            for (const std::uint32_t v : faces[i]) shared = shared || std::ranges::count(faces[k], v) > 0;
            if (!shared && triangles_cross(corners(faces[i]), corners(faces[k]))) ++pairs;
        }
    return pairs;
}

std::vector<Face> live_faces(const CollapseMesh& mesh) {
    std::vector<Face> faces;
    for (const Face& f : mesh.faces)
        if (f[0] != kNone) faces.push_back(f);
    return faces;
}

TEST(Crossings, AgreesWithAllPairsWhileAMeshIsCollapsedAtRandom) {
    CollapseMesh mesh(torus(24, 14), {});
    Crossings crossings(mesh);
    std::mt19937 random(3);
    std::normal_distribution<double> step(0, 0.2);
    EdgeRing ring;
    std::size_t crossed = 0, refused = 0;
    for (int i = 0; i < 4000 && mesh.live_faces() > 100; ++i) {
        const std::uint32_t h = random() % static_cast<std::uint32_t>(3 * mesh.faces.size());
        if (mesh.faces[h / 3][0] == kNone || !mesh.can_collapse(h)) continue;
        mesh.ring(h, mesh.from(h), ring);
        const Vec3 to = mesh.positions[ring.keep] + Vec3{step(random), step(random), step(random)};
        CollapseMesh after = mesh;
        after.collapse(ring, to);
        const bool crosses = crossing_pairs(live_faces(after), after.positions) > 0;
        crossed += crosses ? 1 : 0;
        // Faces with one common vertex are looked after, too, so more is refused than counted here, never less.
        const bool more = crossings.get_more(ring, to);
        refused += more ? 1 : 0;
        EXPECT_TRUE(more || !crosses) << i;
        if (more) continue;
        mesh.collapse(ring, to);
        crossings.collapsed(ring);
    }
    EXPECT_GT(crossed, 50u);
    EXPECT_LT(refused, 4 * crossed);
    EXPECT_LT(mesh.live_faces(), 336u);  // half of all, so that the tree was laid out anew
}

/// Collapses refused among the first ones of a torus whose vertices lie anywhere in a cube.
std::size_t refused_in_tangle(unsigned around, unsigned across) {
    Mesh tangle = torus(around, across);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> anywhere(0, 1);
    for (Vec3& p : tangle.positions) p = {anywhere(random), anywhere(random), anywhere(random)};
    CollapseMesh mesh(tangle, {});
    Crossings crossings(mesh);
    EdgeRing ring;
    std::size_t refused = 0;
    for (std::uint32_t h = 0; h < 300; ++h) {
        if (!mesh.can_collapse(h)) continue;
        mesh.ring(h, mesh.from(h), ring);
        refused += crossings.get_more(ring, {2, 2, 2}) ? 1 : 0;
    }
    return refused;
}

TEST(Crossings, LeavesATangleOfManyFacesAlone) {
    EXPECT_GT(refused_in_tangle(24, 14), 20u);
    EXPECT_EQ(refused_in_tangle(120, 60), 0u);
}

TEST(Crossings, DecimationKeepsThinSheetsApart) {
    // A wavy sheet with a back: base triangles are longer than the waves, and much longer than it is thick.
    Mesh mesh = icosphere(5);
    for (Vec3& p : mesh.positions) p = {p.x, p.y, 0.02 * p.z + 0.1 * std::sin(8 * p.x) * std::sin(8 * p.y)};
    DecimateOptions options;
    options.target_faces = 300;
    const SelfParameterization parameterization(mesh, {}, options);
    EXPECT_LE(parameterization.base().live_faces(), 300u);
    EXPECT_EQ(crossing_pairs(live_faces(parameterization.base()), parameterization.base().positions), 0u);
}

}  // namespace
}  // namespace mvw
