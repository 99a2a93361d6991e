#include "codec/enc_adapt.h"

#include <gtest/gtest.h>

#include "codec/measure/surface_error.h"
#include "tests/support/semi_regular_models.h"

namespace mvw {
namespace {

/// mesh snapped to a grid of 2^-bits, which is its own surface.
Adaptation::Snapped snapped(const SemiRegularMesh& mesh, unsigned bits) {
    PartSurface surface(plain(mesh), 1);
    return Adaptation(surface, {}, 1, mesh).snap(bits, 1);
}

std::vector<Vec3f> coarse_of(const SemiRegularMesh& mesh) {
    std::vector<Vec3f> in(mesh.positions.size()), out(mesh.positions.size());
    std::transform(mesh.positions.begin(), mesh.positions.end(), in.begin(), to_float);
    PatchTransform(mesh.base, mesh.levels, {}, mesh.creases).analyze(in, out);
    return out;
}

TEST(Snap, LeavesCoarsePositionsOnNormalsOfTheGridAndTheSurfaceWhereItWas) {
    SemiRegularMesh ball = bumpy_ball(4);
    for (Vec3& p : ball.positions) p *= 0.25;
    const Mesh input = plain(ball);
    constexpr unsigned kBits = 5;
    const auto [mesh, base] = snapped(ball, kBits);
    PartParams params;
    params.lattice = base.lattice;
    const PartUnits units(mesh.base, mesh.creases, mesh.materials, base.grid, params);
    const std::vector<Vec3f> coarse = coarse_of(mesh);
    double along = 0, across = 0;
    for (std::uint32_t v = 0; v < mesh.base.vertex_count(); ++v) {
        const Vec3f c = units.frame(v).to_local(coarse[v] - units.origin(v));
        along += double{c.x} * c.x;
        across += double{c.y} * c.y + double{c.z} * c.z;
    }
    EXPECT_GT(along, 0);
    EXPECT_LT(across, 0.05 * along);
    EXPECT_LT(surface_error(input, plain(mesh), {20'000, 1}).rms, 1e-3);
}

TEST(Snap, LinesStayWhereTheyAre) {
    SemiRegularMesh mesh = bumpy_ball(3);
    for (Vec3& p : mesh.positions) p *= 0.25;
    mesh.creases.assign(mesh.base.edge_count(), 0);
    mesh.creases[0] = 1;
    const SemiRegularMesh before = mesh;
    const std::vector<std::uint8_t> on_line = line_vertices(mesh);
    mesh = snapped(mesh, 5).mesh;
    for (std::size_t v = 0; v < on_line.size(); ++v) {
        if (on_line[v] != 0) {
            EXPECT_EQ(mesh.positions[v], before.positions[v]);
        }
    }
}

}  // namespace
}  // namespace mvw
