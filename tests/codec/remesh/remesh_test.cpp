#include "codec/remesh/remesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// All parts at their finest level as one mesh.
Mesh joined(const RemeshResult& result) {
    Mesh all;
    for (const SemiRegularMesh& part : result.parts) {
        Mesh mesh;
        mesh.positions = part.positions;
        mesh.faces = triangles_at_level(part.base, part.levels);
        all = join(std::move(all), mesh);
    }
    return all;
}

/// Genus and boundary loops of each component, sorted: what a remesh must keep.
std::vector<std::pair<int, std::uint32_t>> topology(const Mesh& mesh) {
    std::vector<std::uint32_t> component_of_face;
    std::vector<std::pair<int, std::uint32_t>> all;
    for (const Component& c : components(mesh, component_of_face)) all.emplace_back(c.genus, c.boundary_loops);
    std::sort(all.begin(), all.end());
    return all;
}

void expect_sound(const Mesh& input, double psnr, unsigned base_faces = 0) {
    RemeshOptions options;
    options.base_faces = base_faces;
    const RemeshResult result = remesh(input, options);
    const Mesh output = joined(result);
    EXPECT_TRUE(is_clean_manifold(output));
    EXPECT_EQ(topology(input), topology(output));
    EXPECT_EQ(result.alone_area_share, 0);
    SurfaceErrorOptions few;
    few.samples = 50'000;
    EXPECT_GT(surface_error(input, output, few).psnr, psnr);
}

TEST(Remesh, KeepsASphereRound) {
    expect_sound(icosphere(5), 75, 80);
}

TEST(Remesh, SmallBasesKeepThinSpikes) {
    // Twelve spikes with next to no area, so that area says they may go (without cost_of_tips: 1e-2).
    std::vector<Vec3> spikes;
    for (int k = 0; k < 12; ++k) {  // a spiral from pole to pole
        const double z = 1 - (2 * k + 1) / 12.0, turn = 2.4 * k, r = std::sqrt(1 - z * z);
        spikes.push_back({r * std::cos(turn), r * std::sin(turn), z});
    }
    Mesh ball = icosphere(5);
    for (Vec3& p : ball.positions) {
        double nearest = 10;
        for (const Vec3& spike : spikes)
            nearest = std::min(nearest, std::acos(std::clamp(dot(spike, normalized(p)), -1.0, 1.0)));
        p = p * (1 + 0.3 * std::max(0.0, 1 - nearest / 0.06));
    }
    RemeshOptions options;
    options.base_faces = 240;
    EXPECT_LT(surface_error(ball, joined(remesh(ball, options))).max, 8e-3);
}

TEST(Remesh, KeepsAnOpenSquareFlatAndItsBoundary) {
    const Mesh square = grid_mesh(24);
    expect_sound(square, 85, 40);
}

TEST(Remesh, KeepsComponentsApart) {
    Mesh two = icosphere(4);
    for (Vec3& p : two.positions) p += Vec3{5, 0, 0};
    expect_sound(join(icosphere(4), two), 65);
}

TEST(Remesh, WhatIsTooSmallIsItsOwnBase) {
    const RemeshResult result = remesh(tetrahedron_mesh(), {});
    ASSERT_EQ(result.origins, std::vector<PartOrigin>{PartOrigin::Facets});
    EXPECT_EQ(result.parts[0].base.faces(), tetrahedron_mesh().faces);
    EXPECT_LT(surface_error(tetrahedron_mesh(), joined(result), {}).max, 1e-12);
    EXPECT_EQ(result.facets_area_share, 1);
    EXPECT_EQ(result.alone_area_share, 0);
}

TEST(Remesh, ALooseTriangleStaysAloneBesideOthers) {
    Mesh triangle;
    triangle.positions = {{3, 0, 0}, {4, 0, 0}, {3, 1, 0}};
    triangle.faces = {{0, 1, 2}};
    const RemeshResult result = remesh(join(join(triangle, icosphere(4)), tetrahedron_mesh()), {});
    EXPECT_EQ(result.origins, (std::vector<PartOrigin>{PartOrigin::Facets, PartOrigin::Alone, PartOrigin::Recognized}));
    EXPECT_EQ(result.parts[1].base.face_count(), 1u);
    EXPECT_EQ(result.part_of_face.front(), 1u);
    EXPECT_EQ(result.part_of_face.back(), 0u);
    EXPECT_GT(result.alone_area_share, 0);
    EXPECT_LT(result.alone_area_share, 0.1);
}

TEST(Remesh, AFewFacesAreNotToldByManyVertices) {
    RemeshOptions options;
    for (const Mesh& mesh : {moebius_mesh(60), grid_mesh(9)}) {
        CleanReport report;
        const RemeshResult result = remesh(clean(mesh, report), options);
        std::size_t vertices = 0;
        for (const SemiRegularMesh& part : result.parts) vertices += part.positions.size();
        EXPECT_LE(vertices, 6 * mesh.positions.size());
        EXPECT_EQ(result.alone_area_share, 0);
    }
}

TEST(Remesh, DoesNotDependOnSizeOrPlace) {
    const Mesh sphere = icosphere(4);
    const unsigned levels = remesh(sphere, {}).parts.at(0).levels;
    EXPECT_GT(levels, 0u);
    for (const double size : {1e-120, 1e-6, 1e60}) {
        const RemeshResult result = remesh(scaled(sphere, size), {});
        EXPECT_EQ(result.parts.at(0).levels, levels) << size;
        EXPECT_EQ(result.alone_area_share, 0) << size;
    }
    EXPECT_EQ(remesh(moved(scaled(sphere, 0.01), {500'000, 5'500'000, 300}), {}).alone_area_share, 0);
}

TEST(Remesh, MeetsAskedForFacesAndLevels) {
    RemeshOptions options;
    options.base_faces = 1000;
    options.levels = 2;
    const RemeshResult result = remesh(icosphere(4), options);
    EXPECT_EQ(result.parts.at(0).levels, 2u);
    EXPECT_EQ(result.parts.at(0).base.face_count(), 1000u);
}

TEST(Remesh, KeepsTheEdgesOfACubeSharp) {
    Mesh cube = unit_cube();
    while (cube.faces.size() < 4000) {  // finer, the same surface
        const BaseMesh base = BaseMesh::create(static_cast<std::uint32_t>(cube.positions.size()), cube.faces).value();
        std::vector<Vec3> positions = cube.positions;
        for (const BaseEdge& e : base.edges())
            positions.push_back((cube.positions[e.v[0]] + cube.positions[e.v[1]]) * 0.5);
        cube.faces = triangles_at_level(base, 1);
        cube.positions = std::move(positions);
    }
    const RemeshResult result = remesh(cube, {});
    ASSERT_EQ(result.parts.size(), 1u);
    EXPECT_FALSE(result.parts[0].creases.empty());
    EXPECT_LT(surface_error(cube, joined(result), {}).max, 1e-6);
}

TEST(Remesh, KeepsTheTopologyOfRealModels) {
    MVW_SKIP_WITHOUT_MODELS();
    expect_sound(clean_model("bob.obj"), 80);
    expect_sound(clean_model("skull.ply"), 82);
    expect_sound(clean_model("plane_holes.obj"), 70);
    expect_sound(clean_model("bun_zipper.ply"), 80);
}

}  // namespace
}  // namespace mvw
