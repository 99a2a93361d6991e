#include "codec/transform/subdivide.h"

#include <gtest/gtest.h>

#include "codec/transform/level.h"
#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

/// A sheet of equilateral triangles of side 1, w quads wide.
std::vector<Vec3> flat_points(std::uint32_t w) {
    std::vector<Vec3> points;
    for (std::uint32_t y = 0; y <= w; ++y)
        for (std::uint32_t x = 0; x <= w; ++x) points.push_back({x + 0.5 * y, std::sqrt(0.75) * y, 0});
    return points;
}

TEST(Subdivide, KeepsTheControlPointsWhateverTheOptions) {
    for (const test::NamedBase& b : test::all_bases())
        for (const double shape : {0.0, 1.0, 3.0}) {
            const std::vector<Vec3> points = test::random_positions(b.base.vertex_count());
            const std::vector<Vec3> fine =
                subdivide(b.base, points, {.levels = 3, .shape = shape, .s = 0.8}, b.creases);
            ASSERT_EQ(fine.size(), vertices_at_level(b.base, 3)) << b.name;
            EXPECT_TRUE(std::equal(points.begin(), points.end(), fine.begin())) << b.name;
        }
}

TEST(Subdivide, ConstantsStayConstantWithoutShapeEverywhere) {
    for (const test::NamedBase& b : test::all_bases()) {
        const std::size_t V = b.base.vertex_count();
        ShapedPoints points{std::vector<Vec3>(V, {1, 2, 3}), std::vector<Vec3>(V)};
        for (unsigned j = 0; j < 3; ++j) points = subdivide_once(make_level(b.base, j, b.creases), points, 36.0 / 31);
        for (std::size_t i = 0; i < points.v.size(); ++i) {
            ASSERT_LT(length(points.v[i] - Vec3{1, 2, 3}), 1e-14) << b.name;
            ASSERT_LT(length(points.x[i]), 1e-14) << b.name;
        }
    }
}

TEST(Subdivide, ReproducesQuadraticsAndTheirSecondComponentWithinASheet) {
    const std::uint32_t w = 12;
    const BaseMesh base = test::grid(w, w, false);
    const auto height = [](const Vec3& p) { return p.x * p.x - 2 * p.x * p.y + 0.5 * p.y * p.y + p.x; };
    const double laplacian = 3;
    ShapedPoints points{flat_points(w), {}};
    points.x.assign(points.v.size(), {0, 0, -laplacian / 16});  // -(h^2/16) Laplacian, h = 1
    for (Vec3& p : points.v) p.z = height(p);
    const std::vector<Vec3> flat = flat_points(w);
    for (unsigned j = 0; j < 2; ++j) points = subdivide_once(make_level(base, j, {}), points, 36.0 / 31);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.v.size(); ++i) {
        const Vec3& p = points.v[i];
        const double y = p.y / std::sqrt(0.75), x = p.x - 0.5 * y;
        if (std::min({x, y, w - x, w - y}) < 4) continue;
        ++inside;
        EXPECT_NEAR(p.z, height(p), 1e-11);
        EXPECT_NEAR(points.x[i].z, -laplacian / 16 / 16, 1e-12);
    }
    EXPECT_GT(inside, 200u);
}

TEST(Subdivide, ShapeMovesTheSurfaceLinearly) {
    const BaseMesh base = test::octahedron();
    const std::vector<Vec3> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    const auto at = [&](double shape) { return subdivide(base, points, {.levels = 4, .shape = shape}); };
    const std::vector<Vec3> none = at(0), once = at(1), twice = at(2);
    double bulge = 0;
    for (std::size_t i = 0; i < none.size(); ++i) {
        EXPECT_LT(length(twice[i] - once[i] - (once[i] - none[i])), 1e-12);
        bulge += length(once[i]) - length(none[i]);
    }
    EXPECT_GT(bulge / double(none.size()), 0.05);
}

TEST(Subdivide, BoundariesAreTheControlPolygon) {
    const BaseMesh base = test::one_triangle();
    const std::vector<Vec3> points{{0, 0, 0}, {3, 0, 1}, {1, 2, 0}};
    const std::vector<Vec3> fine = subdivide(base, points, {.levels = 1, .shape = 2});
    for (std::size_t e = 0; e < 3; ++e) {
        const BaseEdge& edge = base.edges()[e];
        EXPECT_LT(length(fine[3 + e] - (points[edge.v[0]] + points[edge.v[1]]) * 0.5), 1e-15);
    }
}

}  // namespace
}  // namespace mvw
