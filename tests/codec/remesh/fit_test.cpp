#include "codec/remesh/fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "codec/mesh/refine.h"

namespace mvw {
namespace {

/// A square of 8 base triangles around its centre, [-1, 1]^2, vertex 4.
BaseMesh square() {
    std::vector<Face> faces;
    for (std::uint32_t y = 0; y < 2; ++y)
        for (std::uint32_t x = 0; x < 2; ++x) {
            const std::uint32_t a = 3 * y + x;
            faces.push_back({a, a + 1, a + 4});
            faces.push_back({a, a + 4, a + 3});
        }
    return BaseMesh::create(9, faces).value();
}

std::vector<Vec3> corners() {
    std::vector<Vec3> out;
    for (int k = 0; k < 9; ++k) out.push_back({double(k % 3) - 1, double(k / 3) - 1, 0});
    return out;
}

/// A roof over the square whose ridge runs along x = `ridge`.
Mesh roof(double ridge, unsigned levels) {
    const SemiRegularMesh mesh = refine(square(), corners(), levels, [&](const Vec3& p) {
        return Vec3{p.x, p.y, -std::abs(p.x - ridge)};
    });
    return finest_mesh(std::span(&mesh, 1));
}

TEST(FitCoarse, LeadsVerticesToARidgeAndFixedOnesNowhere) {
    const Mesh input = roof(0.125, 4);
    SemiRegularMesh shown = refine(square(), corners(), 2, [](const Vec3& p) {
        return Vec3{p.x, p.y, -std::abs(p.x)};
    });
    std::vector<std::uint8_t> fixed(9, 0);
    fixed[1] = 1;
    FitOptions options;
    options.samples = 12;
    const std::vector<Vec3> steps = fit_coarse(input, shown.base, 2, shown.positions, 0, fixed, options);
    ASSERT_EQ(steps.size(), 9u);
    EXPECT_EQ(steps[1], Vec3{});
    for (const std::uint32_t v : {4u, 7u}) EXPECT_NEAR(steps[v].x, 0.125, 0.05) << "vertex " << v;
    EXPECT_EQ(fit_coarse(input, shown.base, 2, shown.positions, 0, fixed, {1, 12, 0.05, 0.2, 3}), steps)
        << "with three threads";
}

TEST(FitCoarse, OfALevelItselfIsARoundOfTheFit) {
    const Mesh input = roof(0.125, 4);
    SemiRegularMesh shown = refine(square(), corners(), 2, [](const Vec3& p) {
        return Vec3{p.x, p.y, 0.03 * std::sin(3 * p.y) - std::abs(p.x)};
    });
    const std::vector<std::uint8_t> fixed(shown.positions.size(), 0);
    FitOptions options;
    options.samples = 1000;  // more than a coarse fit lays at least
    const std::vector<Vec3> steps = fit_coarse(input, shown.base, 2, shown.positions, 2, fixed, options);
    std::vector<Vec3> fitted = shown.positions;
    fit(input, triangles_at_level(shown.base, 2), fixed, options, fitted);
    for (std::size_t v = 0; v < fitted.size(); ++v) EXPECT_LT(length(shown.positions[v] + steps[v] - fitted[v]), 1e-4);
}

}  // namespace
}  // namespace mvw
