#include "codec/enc_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

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

}  // namespace
}  // namespace mvw
