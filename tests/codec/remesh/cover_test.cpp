#include "codec/remesh/cover.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "codec/measure/surface_index.h"
#include "codec/remesh/relax.h"
#include "tests/support/meshes.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

constexpr unsigned kCoarse = 3, kFine = 5;  // of icosahedra; vertices of the coarse one come first in the fine one
constexpr double kRadius = 0.08;            // of a spike: half an edge of the coarse sphere
constexpr double kHeight = 0.4;

/// A sphere with a spike between the points of a coarse sphere on it.
struct Spike {
    Spike() : mesh(icosphere(kFine)), triangles(icosphere(kCoarse).faces) {
        tip = static_cast<std::uint32_t>(mesh.positions.size()) - 1;
        const Vec3 axis = mesh.positions[tip];
        for (Vec3& p : mesh.positions) {
            const double out = std::max(0.0, 1 - length(p - axis) / kRadius);
            p = p * (1 + kHeight * out);
        }
        points.resize(icosphere(kCoarse).positions.size());
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                if (mesh.faces[f][k] >= points.size()) continue;
                points[mesh.faces[f][k]] = {f, {}};
                points[mesh.faces[f][k]].weight[k] = 1;
            }
        fixed.assign(points.size(), 0);
    }
    [[nodiscard]] std::vector<Vec3> positions() const {
        const SurfaceWalk on = surface();
        std::vector<Vec3> out;
        for (const FacePoint& p : points) out.push_back(on.position(p));
        return out;
    }
    [[nodiscard]] SurfaceWalk surface() const { return {mesh, {}}; }
    /// From the spike's tip to the triangles.
    [[nodiscard]] double missed() const {
        return SurfaceIndex(positions(), triangles).closest(mesh.positions[tip]).distance;
    }
    Mesh mesh;
    std::vector<Face> triangles;
    std::vector<FacePoint> points;
    std::vector<std::uint8_t> fixed;
    std::uint32_t tip = 0;
};

TEST(Cover, BringsPointsToWhatTrianglesMiss) {
    Spike relaxed, covered;
    ASSERT_GT(relaxed.missed(), 0.8 * kHeight);
    relax(relaxed.surface(), relaxed.triangles, relaxed.fixed, {50, 2, {}}, relaxed.points);
    EXPECT_GT(relaxed.missed(), 0.5 * kHeight);
    relax_to_cover(covered.mesh, covered.surface(), covered.triangles, covered.fixed, 2, covered.points);
    EXPECT_LT(covered.missed(), 1e-9);
}

TEST(Cover, MovesNothingButWhatIsAroundAMissedPlace) {
    Spike spike;
    const std::vector<Vec3> before = spike.positions();
    ASSERT_TRUE(cover_missed(spike.mesh, spike.surface(), spike.triangles, spike.fixed, 2, spike.points));
    EXPECT_LT(spike.missed(), 1e-9);
    const std::vector<Vec3> after = spike.positions();
    std::size_t moved = 0;
    for (std::size_t v = 0; v < before.size(); ++v) {
        if (before[v] == after[v]) continue;
        ++moved;
        EXPECT_LT(length(before[v] - spike.mesh.positions[spike.tip]), 1.3);
    }
    EXPECT_LT(moved, before.size() / 4);
}

TEST(Cover, LeavesWhatIsMissedEvenly) {
    Spike sphere;
    sphere.mesh = icosphere(kFine);
    const std::vector<Vec3> before = sphere.positions();
    EXPECT_FALSE(cover_missed(sphere.mesh, sphere.surface(), sphere.triangles, sphere.fixed, 1, sphere.points));
    EXPECT_EQ(sphere.positions(), before);
}

TEST(Cover, LeavesWhatIsFixed) {
    Spike spike;
    std::ranges::fill(spike.fixed, std::uint8_t{1});
    const std::vector<Vec3> before = spike.positions();
    relax_to_cover(spike.mesh, spike.surface(), spike.triangles, spike.fixed, 2, spike.points);
    EXPECT_FALSE(cover_missed(spike.mesh, spike.surface(), spike.triangles, spike.fixed, 2, spike.points));
    EXPECT_EQ(spike.positions(), before);
}

TEST(Cover, PointsDoNotGoToWhereABoundaryIsCutOff) {
    Mesh square = grid_mesh(16);
    square.positions[7].y = -0.1;  // between two points on its boundary
    const SurfaceWalk surface(square, {});
    std::vector<FacePoint> points(81);  // those of every second row and column
    for (std::uint32_t f = 0; f < square.faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t x = square.faces[f][k] % 17, y = square.faces[f][k] / 17;
            if (x % 2 != 0 || y % 2 != 0) continue;
            points[y / 2 * 9 + x / 2] = {f, {}};
            points[y / 2 * 9 + x / 2].weight[k] = 1;
        }
    const std::vector<std::uint8_t> fixed(points.size(), 0);
    EXPECT_FALSE(cover_missed(square, surface, grid_mesh(8).faces, fixed, 1, points));
}

TEST(Cover, GivesTheSameForAnyNumberOfThreads) {
    Spike one, three;
    relax_to_cover(one.mesh, one.surface(), one.triangles, one.fixed, 1, one.points);
    relax_to_cover(three.mesh, three.surface(), three.triangles, three.fixed, 3, three.points);
    EXPECT_EQ(one.positions(), three.positions());
}

}  // namespace
}  // namespace mvw
