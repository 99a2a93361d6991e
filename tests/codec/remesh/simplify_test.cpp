#include "codec/remesh/simplify.h"

#include <gtest/gtest.h>

#include <set>

#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

TEST(Simplifier, LeavesOfFlatPartsTheirCorners) {
    const Mesh plate = chequered_plate(2);
    Simplifier simplifier(plate);
    simplifier.simplify(120);
    EXPECT_LE(simplifier.faces(), 120u);
    EXPECT_LT(surface_error(plate, simplifier.mesh()).max, 1e-6);
}

TEST(Simplifier, GoesOnFromWhereItStopped) {
    const Mesh torus = rough_torus(61, 37, 0.02);
    Simplifier at_once(torus), in_steps(torus);
    at_once.simplify(500);
    for (const std::size_t faces : {3000u, 1500u, 500u}) in_steps.simplify(faces);
    EXPECT_EQ(at_once.mesh().faces, in_steps.mesh().faces);
    double last = 0;
    Simplifier worse(torus);
    for (const std::size_t faces : {3000u, 1000u, 300u}) {
        worse.simplify(faces);
        const double error = surface_error(torus, worse.mesh()).rms;
        EXPECT_GT(error, last);
        last = error;
    }
}

TEST(Simplifier, KeepsTheTopology) {
    const Mesh torus = mvw::torus(40, 20);
    Simplifier simplifier(torus);
    simplifier.simplify(0);
    CleanReport report;
    const Mesh left = clean(simplifier.mesh(), report);
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const Face& f : left.faces)
        for (unsigned c = 0; c < 3; ++c) edges.insert(std::minmax(f[c], f[(c + 1) % 3]));
    EXPECT_EQ(2 * edges.size(), 3 * left.faces.size()) << "closed";
    EXPECT_EQ(left.positions.size() + left.faces.size(), edges.size()) << "of one handle";
    EXPECT_LT(left.faces.size(), 100u);
}

TEST(Simplifier, KeepsBoundariesAndBordersOfMaterials) {
    Mesh sheet;  // of 20 by 20 cells, its left half of one material, its right half of another
    constexpr std::uint32_t kCells = 20;
    for (std::uint32_t y = 0; y <= kCells; ++y)
        for (std::uint32_t x = 0; x <= kCells; ++x) sheet.positions.push_back({double(x), double(y), 0});
    for (std::uint32_t y = 0; y < kCells; ++y)
        for (std::uint32_t x = 0; x < kCells; ++x) {
            const std::uint32_t a = y * (kCells + 1) + x, b = a + kCells + 1;
            sheet.faces.insert(sheet.faces.end(), {{a, a + 1, b + 1}, {a, b + 1, b}});
            for (unsigned k = 0; k < 2; ++k) sheet.materials.push_back(x < kCells / 2 ? 0 : 1);
        }
    Simplifier simplifier(sheet);
    simplifier.simplify(8);
    const Mesh left = simplifier.mesh();
    ASSERT_EQ(left.materials.size(), left.faces.size());
    EXPECT_LE(left.faces.size(), 40u);
    EXPECT_LT(surface_error(sheet, left).max, 1e-9);
    for (std::size_t f = 0; f < left.faces.size(); ++f)
        for (const std::uint32_t v : left.faces[f]) {
            const double x = left.positions[v].x;
            EXPECT_TRUE(left.materials[f] == 0 ? x <= kCells / 2 + 1e-9 : x >= kCells / 2 - 1e-9);
        }
}

}  // namespace
}  // namespace mvw
