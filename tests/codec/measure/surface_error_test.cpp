#include "codec/measure/surface_error.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/shapes.h"

namespace mvw {
namespace {

constexpr SurfaceErrorOptions kQuick{.samples = 20'000};

TEST(SurfaceError, EqualSurfacesHaveNone) {
    const Mesh sphere = icosphere(4);
    const SurfaceError e = surface_error(sphere, sphere, kQuick);
    EXPECT_EQ(e.rms, 0);
    EXPECT_EQ(e.mean, 0);
    EXPECT_EQ(e.max, 0);
    EXPECT_TRUE(std::isinf(e.psnr));
    EXPECT_LT(e.normal_deg, 1e-3);
}

TEST(SurfaceError, ParallelSquaresLieTheirHeightApart) {
    const SurfaceError e = surface_error(unit_square(), moved(unit_square(), {0, 0, 0.1}), kQuick);
    const double expected = 0.1 / std::sqrt(2.0);
    EXPECT_NEAR(e.rms, expected, 1e-12);
    EXPECT_NEAR(e.mean, expected, 1e-12);
    EXPECT_NEAR(e.max, expected, 1e-12);
    EXPECT_NEAR(e.psnr, -20 * std::log10(expected), 1e-9);
    EXPECT_NEAR(e.normal_deg, 0, 1e-9);
}

// As STL files have them.
Mesh with_corners_of_their_own(const Mesh& mesh) {
    Mesh out;
    for (const Face& face : mesh.faces) {
        const auto first = static_cast<std::uint32_t>(out.positions.size());
        for (const std::uint32_t v : face) out.positions.push_back(mesh.positions[v]);
        out.faces.push_back({first, first + 1, first + 2});
    }
    return out;
}

TEST(SurfaceError, VerticesAtOnePositionCountOnce) {
    Mesh spike = icosphere(2);
    spike.positions[0] = spike.positions[0] * 1.5;
    const SurfaceError together = surface_error(icosphere(3), spike, {.samples = 0});
    const SurfaceError apart = surface_error(icosphere(3), with_corners_of_their_own(spike), {.samples = 0});
    EXPECT_NEAR(apart.rms, together.rms, 1e-12);
    EXPECT_NEAR(apart.mean, together.mean, 1e-12);
    EXPECT_EQ(apart.max, together.max);
}

TEST(SurfaceError, TurnedSurfaceShowsInTheNormalsAlone) {
    Mesh turned = unit_square();
    for (Face& f : turned.faces) std::swap(f[0], f[1]);
    const SurfaceError e = surface_error(unit_square(), turned, kQuick);
    EXPECT_EQ(e.rms, 0);
    EXPECT_NEAR(e.normal_deg, 180, 1e-9);
}

TEST(SurfaceError, ConcentricSpheresDifferByTheirRadii) {
    const double expected = 0.1 / bounding_box(icosphere(5)).diagonal();
    const SurfaceError e = surface_error(icosphere(5), scaled(icosphere(5), 1.1), kQuick);
    EXPECT_NEAR(e.mean, expected, 0.002 * expected);
    EXPECT_NEAR(e.rms, expected, 0.002 * expected);
    EXPECT_NEAR(e.max, expected, 0.01 * expected);
}

// A unit cube moved by d along x. Squared distance over its 6 faces: x = 0 lies d outside the other cube; x = 1 lies
// inside, d from its end but nearer to its sides around the rim, where density of depth e is 4 (1 - 2e); of each of the
// four sides a strip of width d sticks out, with d^3/3.
TEST(SurfaceError, MovedCubeHasTheMeanSquareThatGeometryGives) {
    const double d = 0.1;
    const SurfaceError e = surface_error(unit_cube(), moved(unit_cube(), {d, 0, 0}), {.samples = 500'000});
    const double inside = d * d * (1 - 2 * d) * (1 - 2 * d) + 4 * d * d * d / 3 - 2 * d * d * d * d;
    const double expected = std::sqrt((d * d + inside + 4 * d * d * d / 3) / 6) / std::sqrt(3.0);
    EXPECT_NEAR(e.rms, expected, 0.002 * expected);
    EXPECT_NEAR(e.max, d / std::sqrt(3.0), 1e-12);
}

TEST(SurfaceError, MissingPieceShowsFromTheWholeToTheOpenSurfaceAndIsSymmetric) {
    Mesh open = unit_cube();
    open.faces.resize(10);  // without the face at x = 1
    const SurfaceError e = surface_error(unit_cube(), open, {.samples = 200'000});
    // The nearest side of the missing square: distance 1/2 in its middle, 2 * integral of min(x,1-x,y,1-y)^2 = 1/24.
    EXPECT_NEAR(e.max, 0.5 / std::sqrt(3.0), 0.005);
    EXPECT_NEAR(e.rms, std::sqrt((1.0 / 24) / 6) / std::sqrt(3.0), 0.001);
    const SurfaceError back = surface_error(open, unit_cube(), {.samples = 200'000});
    EXPECT_NEAR(back.rms, e.rms, 1e-12);
    EXPECT_NEAR(back.max, e.max, 1e-12);
}

TEST(SurfaceError, DoesNotDependOnTheThreadCount) {
    const Mesh a = icosphere(4), b = moved(icosphere(3), {0.01, 0.02, 0});
    const SurfaceError one = surface_error(a, b, {.samples = 50'000, .threads = 1});
    const SurfaceError four = surface_error(a, b, {.samples = 50'000, .threads = 4});
    EXPECT_EQ(one.rms, four.rms);
    EXPECT_EQ(one.mean, four.mean);
    EXPECT_EQ(one.max, four.max);
    EXPECT_EQ(one.normal_deg, four.normal_deg);
}

TEST(SurfaceError, IsTheSameFarFromTheOriginAndAtAnySize) {
    const SurfaceError near = surface_error(icosphere(4), icosphere(3), kQuick);
    for (const double size : {1e-30, 1e30}) {
        const SurfaceError e = surface_error(scaled(icosphere(4), size), scaled(icosphere(3), size), kQuick);
        EXPECT_NEAR(e.rms, near.rms, 1e-6 * near.rms) << size;
    }
    const Vec3 away{1e6, -2e6, 3e6};
    const SurfaceError far = surface_error(moved(icosphere(4), away), moved(icosphere(3), away), kQuick);
    EXPECT_NEAR(far.rms, near.rms, 1e-5 * near.rms);
}

TEST(SurfaceError, MeasuresSurfacesThatAreFarApart) {
    for (const double gap : {1e3, 1e7, 1e20}) {
        const SurfaceError e = surface_error(unit_square(), moved(unit_square(), {0, 0, gap}), {.samples = 100});
        EXPECT_NEAR(e.rms, gap / std::sqrt(2.0), 1e-9 * gap);
    }
}

TEST(SurfaceError, VerticesCountEvenWithoutSamples) {
    Mesh spike = unit_square();
    spike.positions[2].z = 0.25;
    EXPECT_GT(surface_error(unit_square(), spike, {.samples = 0}).max, 0.1);
}

TEST(SurfaceError, UnusedVerticesDoNotCount) {
    Mesh mesh = unit_square();
    mesh.positions.push_back({1e9, 0, 0});
    EXPECT_EQ(surface_error(mesh, unit_square(), kQuick).max, 0);
    EXPECT_EQ(surface_error(unit_square(), mesh, kQuick).max, 0);
}

TEST(SurfaceError, VertexErrorsAreDistancesOverTheDiagonal) {
    const std::vector<Vec3> points{{0.5, 0.5, 0.3}, {0.25, 0.5, 0}, {2, 0.5, 0}};
    const std::vector<double> e = vertex_errors(unit_square(), points);
    EXPECT_NEAR(e[0], 0.3 / std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(e[1], 0, 1e-12);
    EXPECT_NEAR(e[2], 1 / std::sqrt(2.0), 1e-12);
}

TEST(SurfaceError, TakesEveryVertexOrSomeOfThem) {
    Mesh spike = unit_square();  // its points lie on the square but for the last vertex
    spike.positions.push_back({0.5, 0.5, 0.5});
    spike.faces.push_back({0, 1, 4});
    SurfaceErrorOptions options{.samples = 0, .threads = 1};
    EXPECT_GT(surface_error(unit_square(), spike, options).max, 0.3);
    options.vertex_stride = 5;  // the first alone
    EXPECT_EQ(surface_error(unit_square(), spike, options).max, 0);
}

TEST(ReferenceSurface, MeasuresManySurfacesAsSurfaceErrorDoes) {
    const ReferenceSurface reference(icosphere(3), 1);
    for (const double size : {1.01, 1.1}) {
        const Mesh other = scaled(icosphere(3), size);
        EXPECT_EQ(reference.error_of(other, kQuick).rms, surface_error(icosphere(3), other, kQuick).rms);
    }
    const SurfacePoint hit = reference.closest({0, 0, 3});
    EXPECT_NEAR(hit.distance, 2, 0.02);
    EXPECT_NEAR(length(hit.point), 1, 0.02);
}

TEST(Measurable, NeedsAreaAndAFiniteBox) {
    EXPECT_TRUE(measurable(unit_square()));
    EXPECT_TRUE(measurable(scaled(unit_square(), 1e30)));
    EXPECT_TRUE(measurable(scaled(unit_square(), 1e-30)));
    EXPECT_FALSE(measurable(Mesh{}));
    EXPECT_FALSE(measurable(mesh_of({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}})));
    EXPECT_FALSE(measurable(mesh_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}})));
}

}  // namespace
}  // namespace mvw
