#include "codec/remesh/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/meshes.h"

namespace mvw {
namespace {

/// A sheet folded up by a right angle along its middle, its vertices off by up to `noise` of an edge.
Mesh folded_sheet(double noise) {
    Mesh mesh = grid_mesh(48);
    const double edge = length(mesh.positions[1] - mesh.positions[0]);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> off(-noise * edge, noise * edge);
    const Box box = bounding_box(mesh);
    for (Vec3& p : mesh.positions) {
        const double beyond = p.x - box.center().x;
        if (beyond > 0) p.x -= beyond, p.z += beyond;
        p += Vec3{off(random), off(random), off(random)};
    }
    return mesh;
}

TEST(Features, FollowASharpEdgeBetweenSmoothSides) {
    const std::vector<std::uint8_t> sharp = feature_half_edges(folded_sheet(0));
    EXPECT_EQ(std::count(sharp.begin(), sharp.end(), 1), 2 * 48);
}

TEST(Features, TakeSharpEdgesAmongRoughOnesForNoise) {
    const std::vector<std::uint8_t> sharp = feature_half_edges(folded_sheet(0.25));
    EXPECT_EQ(std::count(sharp.begin(), sharp.end(), 1), 0);
}

}  // namespace
}  // namespace mvw
