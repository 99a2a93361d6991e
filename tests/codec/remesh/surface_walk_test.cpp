#include "codec/remesh/surface_walk.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "tests/support/meshes.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// A square of two triangles in the plane z = 0 and, folded up at x = 1 by a right angle, one more beside it.
Mesh folded_strip() {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}};
    mesh.faces = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}};
    return mesh;
}

void expect_near(const Vec3& a, const Vec3& b) {
    EXPECT_NEAR(length(a - b), 0, 1e-12) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(SurfaceWalk, GoesStraightOverAPlane) {
    const Mesh square = grid_mesh(8);
    const SurfaceWalk surface(square, {});
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(0.2, 0.4), way(-0.15, 0.15);
    const Box box = bounding_box(square);
    for (int k = 0; k < 200; ++k) {
        const double a = share(random), b = share(random);
        const FacePoint from{static_cast<std::uint32_t>(random() % square.faces.size()), {a, b, 1 - a - b}};
        const Vec3 p = surface.position(from), step = Vec3{way(random), way(random), 0} * box.diagonal();
        const Vec3 to = p + step;
        if (to.x < box.min.x || to.x > box.max.x || to.y < box.min.y || to.y > box.max.y) continue;
        expect_near(surface.position(surface.walk(from, step)), to);
    }
}

TEST(SurfaceWalk, UnfoldsTheFacesItCrosses) {
    const Mesh strip = folded_strip();
    const SurfaceWalk surface(strip, {});
    const FacePoint from{0, {0.25, 0.5, 0.25}};  // (0.75, 0.25, 0)
    expect_near(surface.position(surface.walk(from, {0.75, 0.25, 0})), {1, 0.5, 0.5});
}

TEST(SurfaceWalk, StopsAtBoundariesAndSharpEdges) {
    const Mesh strip = folded_strip();
    const FacePoint from{0, {0.25, 0.5, 0.25}};
    expect_near(SurfaceWalk(strip, {}).position(SurfaceWalk(strip, {}).walk(from, {0, -1, 0})), {0.75, 0, 0});
    std::vector<std::uint8_t> sharp(12, 0);
    sharp[1] = sharp[3 * 3 + 2] = 1;  // 1 -> 2 and 2 -> 1
    const SurfaceWalk surface(strip, sharp);
    expect_near(surface.position(surface.walk(from, {0.75, 0, 0})), {1, 0.25, 0});
}

TEST(SurfaceWalk, AveragesNormalsButNotOverSharpEdges) {
    const Mesh strip = folded_strip();
    std::vector<std::uint8_t> sharp(12, 0);
    sharp[1] = sharp[3 * 3 + 2] = 1;
    const FacePoint at_fold{0, {0, 0.5, 0.5}};
    expect_near(SurfaceWalk(strip, sharp).normal(at_fold), {0, 0, 1});
    const Vec3 smooth = SurfaceWalk(strip, {}).normal(at_fold);
    EXPECT_NEAR(smooth.x, -smooth.z, 1e-12);
}

TEST(SurfaceWalk, KeepsTheLengthOfAWayRoundASphere) {
    const Mesh sphere = icosphere(4);
    const SurfaceWalk surface(sphere, {});
    const FacePoint from{7, {0.3, 0.3, 0.4}};
    const Vec3 p = surface.position(from);
    const Vec3 along = normalized(cross(p, Vec3{0.3, 0.5, 0.8}));
    const Vec3 half = surface.position(surface.walk(from, along * std::numbers::pi));
    EXPECT_LT(dot(normalized(half), normalized(p)), -0.99);
}

}  // namespace
}  // namespace mvw
