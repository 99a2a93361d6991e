#include "codec/enc_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "codec/entropy/lattice_cells.h"
#include "codec/measure/surface_error.h"
#include "codec/part_params.h"
#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

double largest_move(const std::vector<Vec3>& positions, const Rounded& rounded) {
    double most = 0;
    for (std::size_t v = 0; v < positions.size(); ++v)
        for (std::size_t a = 0; a < 3; ++a)
            most = std::max(most, std::abs(rounded.lattice.point(rounded.grid[v])[a] - positions[v][a]));
    return most;
}

TEST(Lattice, NearestPointsAreNearest) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> coordinate(-0.5, 0.5);
    const Lattice lattice{7, {0, 90, 255}, {0, 17, 200}};
    for (int i = 0; i < 1000; ++i) {
        const Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
        const Vec3 off = lattice.point(lattice.nearest(p)) - p;
        for (std::size_t a = 0; a < 3; ++a)
            EXPECT_LE(std::abs(off[a]), 0.5 * lattice.unit() * (1 + lattice.stretch[a] / 512.0) + 1e-12);
    }
    EXPECT_TRUE((Lattice{9, {}, {}}).is_plain());
    EXPECT_FALSE(lattice.is_plain());
}

/// Two planes an axis: any cell that divides what is between them takes both.
TEST(Lattice, ABoxOfAnySizeLiesOnOneOfFewBits) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> size(0.2, 0.6), place(-0.2, 0.2);
    for (int i = 0; i < 20; ++i) {
        Mesh box = unit_cube();
        const Vec3 scale{size(random), size(random), size(random)}, at{place(random), place(random), place(random)};
        for (Vec3& p : box.positions)
            for (std::size_t a = 0; a < 3; ++a) p[a] = p[a] * scale[a] + at[a];
        const Rounded fitted = round_to_lattice(box.positions, box.faces, 6);
        EXPECT_FALSE(fitted.lattice.is_plain());
        EXPECT_LT(largest_move(box.positions, fitted), 0.02 * fitted.lattice.unit());
    }
}

TEST(Lattice, SurfacesThatLieAnywhereKeepThePlainOne) {
    const SemiRegularMesh ball = bumpy_ball(3);
    const Mesh mesh = plain(ball);
    for (const unsigned bits : {6u, 10u, 14u}) {
        const Lattice lattice = fit_lattice(mesh.positions, mesh.faces, bits);
        EXPECT_TRUE(lattice.is_plain()) << bits;
        EXPECT_EQ(lattice.bits, bits);
    }
}

TEST(Lattice, SurfacesWithoutAreaOrFacesKeepThePlainOne) {
    const std::vector<Vec3> positions{{0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}};
    EXPECT_TRUE(fit_lattice(positions, {{0, 1, 2}}, 8).is_plain());
    EXPECT_TRUE(fit_lattice(positions, {}, 8).is_plain());
}

TEST(Lattice, CellsOfNestedOnesAreTwoOfTheNext) {
    for (const std::int32_t k : {-65, -1, 0, 1, 40}) {
        const LatticeCells cells(Lattice::nested(7), Lattice::nested(8), 1, k);
        EXPECT_EQ(cells.first(), 2 * k);
        EXPECT_EQ(cells.last(), 2 * k + 1);
        EXPECT_EQ(cells.share(2 * k), 1);
        EXPECT_EQ(cells.share(2 * k + 1), 1);
    }
}

TEST(Lattice, NestedOnesFitAxesThatGainByItAlone) {
    const Mesh ball = plain(bumpy_ball(3));
    EXPECT_TRUE(fit_nested_lattice(ball.positions, ball.faces, 9).is_nested());
    EXPECT_TRUE(fit_nested_lattice(ball.positions, {}, 9).is_nested());

    Mesh prism = plain(bumpy_ball(5));  // lies anywhere but between two planes
    for (Vec3& p : prism.positions) p.z = p.z > 0 ? 0.2371 : -0.1239;
    const Lattice lattice = fit_nested_lattice(prism.positions, prism.faces, 6);
    for (const std::size_t a : {0u, 1u}) {
        EXPECT_EQ(lattice.stretch[a], 0);
        EXPECT_EQ(lattice.shift[a], Lattice::kHalf);
    }
    for (const Vec3& p : prism.positions) EXPECT_NEAR(lattice.point(lattice.nearest(p)).z, p.z, 0.02 * lattice.unit());
}

TEST(Lattice, WhatRoundingMovesIsWhatIsMeasured) {
    // Edges are ten cells long. bumpy_ball's diagonal is the unit of what is measured.
    const Mesh ball = plain(bumpy_ball(4));
    const Rounded rounded = round_to(Lattice::nested(7), ball.positions);
    Mesh moved = ball;
    moved.positions = points_of(rounded);
    const SurfaceError error = surface_error(ball, moved, {.samples = 50'000, .vertex_stride = 1'000'000});
    EXPECT_NEAR(moved_by_rounding(rounded, ball.positions, ball.faces), error.rms * bounding_box(ball).diagonal(),
                0.03 * error.rms * bounding_box(ball).diagonal());
    EXPECT_EQ(moved_by_rounding(rounded, ball.positions, {}), 0);

    // Along itself a plane does not move.
    Mesh plane = plain(bumpy_ball(4));
    for (Vec3& p : plane.positions) p.z = 0;
    EXPECT_NEAR(moved_by_rounding(round_to({7, {}, {}}, plane.positions), plane.positions, plane.faces), 0, 1e-12);
}

TEST(Lattice, PlainAndNestedOnesTakeAByte) {
    for (const auto& [lattice, size] :
         {std::pair{Lattice{11, {}, {}}, 1u}, {Lattice::nested(9), 1u}, {Lattice{30, {3, 0, 9}, {128, 128, 7}}, 7u}}) {
        ByteWriter out;
        write_lattice(out, lattice);
        const Bytes bytes = out.take();
        EXPECT_EQ(bytes.size(), size);
        ByteReader in(bytes);
        EXPECT_EQ(read_lattice(in), lattice);
        EXPECT_TRUE(in.ok());
    }
}

}  // namespace
}  // namespace mvw
