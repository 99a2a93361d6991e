#include "codec/remesh/drift.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/meshes.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// A square sheet whose own vertices are the points; its rim is fixed.
struct Sheet {
    Sheet() : mesh(grid_mesh(12)), surface(mesh, {}), points(mesh.positions.size()), fixed(points.size(), 0) {
        std::vector<std::uint32_t> uses(points.size(), 0);
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = mesh.faces[f][k];
                points[v] = {f, {0, 0, 0}};
                points[v].weight[k] = 1;
                ++uses[v];
            }
        for (std::size_t v = 0; v < points.size(); ++v) fixed[v] = uses[v] < 6 ? 1 : 0;
        inner = static_cast<std::uint32_t>(std::find(fixed.begin(), fixed.end(), 0) - fixed.begin());
        edge = length(mesh.positions[1] - mesh.positions[0]);
    }
    Mesh mesh;
    SurfaceWalk surface;
    std::vector<FacePoint> points;
    std::vector<std::uint8_t> fixed;
    std::uint32_t inner = 0;
    double edge = 0;
};

TEST(Drift, WalksWhereTheStepsLead) {
    const Sheet s;
    Drift drift(s.surface, s.mesh.faces, s.fixed, s.points, 1);
    std::vector<Vec3> steps(s.points.size());
    steps[s.inner] = Vec3{0.2, 0.1, 0} * s.edge;
    drift.move(steps);
    EXPECT_LT(length(drift.position(s.inner) - s.mesh.positions[s.inner] - steps[s.inner]), 1e-9);
}

TEST(Drift, StopsBeforeTrianglesTurnOver) {
    const Sheet s;
    Drift drift(s.surface, s.mesh.faces, s.fixed, s.points, 1);
    const std::vector<Vec3> steps(s.points.size(), Vec3{0.7, 0.4, 0} * s.edge);
    const Vec3 up = drift.normal(s.inner);
    for (int round = 0; round < 30; ++round) drift.move(steps);
    for (const Face& f : s.mesh.faces) {
        const Vec3 &a = drift.position(f[0]), &b = drift.position(f[1]), &c = drift.position(f[2]);
        EXPECT_GT(dot(cross(b - a, c - a), up), 0);
    }
    for (std::uint32_t v = 0; v < s.points.size(); ++v)
        EXPECT_TRUE(s.fixed[v] == 0 || drift.position(v) == s.mesh.positions[v]);
}

TEST(Drift, RefusesAPlaceBeyondTheRing) {
    const Sheet s;
    Drift drift(s.surface, s.mesh.faces, s.fixed, s.points, 1);
    const FacePoint far = s.surface.walk(s.points[s.inner], Vec3{3, 2, 0} * s.edge);
    EXPECT_FALSE(drift.put(s.inner, far));
    EXPECT_EQ(length(drift.position(s.inner) - s.mesh.positions[s.inner]), 0);
    EXPECT_TRUE(drift.put(s.inner, s.surface.walk(s.points[s.inner], Vec3{0.1, 0.2, 0} * s.edge)));
}

TEST(Rings, GroupsHoldNoNeighboursAndEveryVertexThatMoves) {
    const Mesh mesh = icosphere(3);
    const Rings rings(mesh.faces, mesh.positions.size());
    std::vector<int> group(mesh.positions.size(), -1);
    int number = 0;
    std::vector<std::uint8_t> fixed(mesh.positions.size(), 0);
    fixed[5] = 1;
    for (const auto& members : rings.independent_groups(fixed)) {
        for (const std::uint32_t v : members) group[v] = number;
        ++number;
    }
    for (std::uint32_t v = 0; v < group.size(); ++v) {
        EXPECT_EQ(group[v] < 0, v == 5);
        for (const RingTriangle& t : rings.at(v)) EXPECT_TRUE(v == 5 || group[t.first] != group[v]);
    }
}

}  // namespace
}  // namespace mvw
