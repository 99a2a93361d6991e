#include "codec/remesh/settle.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "codec/measure/surface_error.h"
#include "codec/mesh/semi_regular.h"
#include "codec/remesh/iron.h"
#include "codec/remesh/remesh.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"
#include "tools/bench/folds.h"

namespace mvw {
namespace {

/// A sheet some of whose vertices have been pushed over their neighbours.
struct Crumpled {
    Mesh flat = grid_mesh(12), mesh = flat;
    std::vector<std::uint8_t> fixed = std::vector<std::uint8_t>(flat.positions.size(), 0);

    Crumpled() {
        const double edge = length(flat.positions[1] - flat.positions[0]);
        for (const std::uint32_t v : {40u, 45u, 84u, 110u}) mesh.positions[v].x += 1.3 * edge;
        mesh.positions[70] = mesh.positions[71];  // triangles without area
    }
};

std::size_t without_area(const Mesh& mesh) {
    return static_cast<std::size_t>(std::ranges::count_if(mesh.faces, [&](const Face& f) {
        return length(cross(mesh.positions[f[1]] - mesh.positions[f[0]], mesh.positions[f[2]] - mesh.positions[f[0]])) <
               1e-9;
    }));
}

TEST(Iron, LeavesNoFoldAndNoTriangleWithoutArea) {
    Crumpled sheet;
    ASSERT_GT(bench::count_folds(sheet.mesh), 4u);
    ASSERT_GT(without_area(sheet.mesh), 0u);
    const std::size_t moved = iron(sheet.mesh.faces, sheet.fixed, sheet.mesh.positions);
    EXPECT_EQ(bench::count_folds(sheet.mesh), 0u);
    EXPECT_EQ(without_area(sheet.mesh), 0u);
    EXPECT_GE(moved, 5u);
}

TEST(Iron, MovesNothingElse) {
    Crumpled sheet;
    sheet.fixed.assign(sheet.fixed.size(), 1);
    const std::vector<Vec3> before = sheet.mesh.positions;
    EXPECT_EQ(iron(sheet.mesh.faces, sheet.fixed, sheet.mesh.positions), 0u);
    EXPECT_EQ(sheet.mesh.positions, before) << "all are fixed";
    Mesh sphere = icosphere(4);
    const std::vector<Vec3> round = sphere.positions;
    EXPECT_EQ(iron(sphere.faces, std::vector<std::uint8_t>(round.size(), 0), sphere.positions), 0u);
    EXPECT_EQ(sphere.positions, round) << "nothing is folded";
}

TEST(Settle, LeavesFoldsThatCoverATip) {
    Mesh spike = grid_mesh(12);  // a blade, thin enough for its sides to look like a fold
    for (const std::uint32_t v : {84u, 85u}) spike.positions[v].z += 1;
    std::vector<Vec3> positions = spike.positions;
    ASSERT_GT(bench::count_folds(spike), 0u);
    const std::vector<Vec3> unknown(positions.size());
    settle(spike, spike.faces, std::vector<std::uint8_t>(positions.size(), 0), unknown, {}, positions);
    EXPECT_NEAR(positions[84].z, spike.positions[84].z, 0.02);
}

TEST(Settle, IronsManyFoldsOfRealRemeshes) {
    MVW_SKIP_WITHOUT_MODELS();
    const RemeshResult human = remesh(clean_model("human.obj"), {});
    EXPECT_LT(bench::count_folds(finest_mesh(human.parts)), 100u) << "164 without ironing";
    const Mesh mesh = clean_model("human.obj");
    EXPECT_GT(surface_error(mesh, finest_mesh(human.parts), {}).psnr, 82);
}

}  // namespace
}  // namespace mvw
