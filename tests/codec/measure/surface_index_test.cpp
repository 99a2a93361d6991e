#include "codec/measure/surface_index.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// Answer of a search over all triangles.
double distance_to_all(const Mesh& mesh, const Vec3& p) {
    double best = 1e300;
    for (const Face& f : mesh.faces) {
        const Vec3 &a = mesh.positions[f[0]], &b = mesh.positions[f[1]], &c = mesh.positions[f[2]];
        const std::array<double, 3> w = closest_on_triangle(p, a, b, c);
        best = std::min(best, length(a * w[0] + b * w[1] + c * w[2] - p));
    }
    return best;
}

TEST(ClosestOnTriangle, FindsEveryRegion) {
    const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
    const auto at = [&](const Vec3& p) { return closest_on_triangle(p, a, b, c); };
    EXPECT_EQ(at({-1, -1, 3}), (std::array<double, 3>{1, 0, 0}));
    EXPECT_EQ(at({2, -1, 3}), (std::array<double, 3>{0, 1, 0}));
    EXPECT_EQ(at({-1, 2, 3}), (std::array<double, 3>{0, 0, 1}));
    EXPECT_EQ(at({0.25, -1, 0}), (std::array<double, 3>{0.75, 0.25, 0}));
    EXPECT_EQ(at({-1, 0.25, 0}), (std::array<double, 3>{0.75, 0, 0.25}));
    EXPECT_EQ(at({1, 1, 0}), (std::array<double, 3>{0, 0.5, 0.5}));
    EXPECT_EQ(at({0.25, 0.25, -7}), (std::array<double, 3>{0.5, 0.25, 0.25}));
}

TEST(ClosestOnTriangle, HandlesTrianglesWithoutArea) {
    const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{3, 0, 0}, p{2, 5, 0};
    const std::array<double, 3> w = closest_on_triangle(p, a, b, c);
    EXPECT_NEAR(length(a * w[0] + b * w[1] + c * w[2] - Vec3{2, 0, 0}), 0, 1e-12);
    EXPECT_EQ(closest_on_triangle(p, a, a, a), (std::array<double, 3>{1, 0, 0}));
}

TEST(SurfaceIndex, AgreesWithASearchOverAllTriangles) {
    const Mesh mesh = moved(scaled(icosphere(3), 7), {100, 0, 0});
    const SurfaceIndex index(mesh.positions, mesh.faces);
    std::mt19937_64 random(1);
    std::normal_distribution<double> coordinate(0, 7);
    std::uint32_t near_face = kNone;
    for (int i = 0; i < 300; ++i) {
        const Vec3 p = Vec3{100, 0, 0} + Vec3{coordinate(random), coordinate(random), coordinate(random)};
        const SurfacePoint hit = index.closest(p, near_face);
        near_face = hit.face;
        EXPECT_NEAR(hit.distance, distance_to_all(mesh, p), 1e-12);
        EXPECT_NEAR(length(hit.point - p), hit.distance, 1e-12);
        const Face& f = mesh.faces[hit.face];
        Vec3 q{};
        for (std::size_t k = 0; k < 3; ++k) q += mesh.positions[f[k]] * hit.barycentric[k];
        EXPECT_NEAR(length(q - hit.point), 0, 1e-12);
    }
}

TEST(SurfaceIndex, NearFaceNeverChangesTheAnswer) {
    const Mesh mesh = unit_cube();
    const SurfaceIndex index(mesh.positions, mesh.faces);
    for (const Vec3& p : {Vec3{0, 0, 0}, Vec3{2, 2, 2}, Vec3{0.5, 0.5, 0.5}, Vec3{0.5, 0, 0.5}}) {
        const SurfacePoint plain = index.closest(p);
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
            EXPECT_EQ(index.closest(p, f).face, plain.face);
            EXPECT_EQ(index.closest(p, f).distance, plain.distance);
        }
    }
}

TEST(SurfaceIndex, IsExactFarFromTheOriginWhereFloatsAreNot) {
    const Mesh mesh = moved(scaled(icosphere(2), 0.01), {1e6, 1e6, 1e6});
    const SurfaceIndex index(mesh.positions, mesh.faces);
    const Vec3 p{1e6 + 0.004, 1e6 - 0.02, 1e6 + 0.001};
    EXPECT_NEAR(index.closest(p).distance, distance_to_all(mesh, p), 1e-9);
}

TEST(SurfaceIndex, AgreesForPointsAtAnyDistance) {
    const Mesh mesh = icosphere(3);
    const SurfaceIndex index(mesh.positions, mesh.faces);
    std::mt19937_64 random(2);
    std::normal_distribution<double> coordinate;
    for (const double far : {1e-9, 0.5, 1.0, 30.0, 1e3, 1e8, 1e14, 1e16, 1e30})
        for (int i = 0; i < 40; ++i) {
            const Vec3 p = Vec3{coordinate(random), coordinate(random), coordinate(random)} * far;
            const double nearest = distance_to_all(mesh, p);
            EXPECT_NEAR(index.closest(p, i % 2 == 0 ? kNone : 7u).distance, nearest, 1e-12 * nearest) << far;
        }
}

}  // namespace
}  // namespace mvw
