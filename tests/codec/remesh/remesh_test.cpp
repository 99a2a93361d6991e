#include "codec/remesh/remesh.h"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(Remesh, KeepsAnOpenSquareFlatAndItsBoundary) {
    const Mesh square = grid_mesh(24);
    expect_sound(square, 85, 40);
}

TEST(Remesh, KeepsComponentsApart) {
    Mesh two = icosphere(4);
    for (Vec3& p : two.positions) p += Vec3{5, 0, 0};
    expect_sound(join(icosphere(4), two), 65);
}

TEST(Remesh, CodesWhatIsTooSmallAsItIs) {
    const Mesh tetrahedron = tetrahedron_mesh();
    const RemeshResult result = remesh(tetrahedron, {});
    ASSERT_EQ(result.parts.size(), 1u);
    EXPECT_EQ(result.parts[0].levels, 0u);
    EXPECT_EQ(result.parts[0].positions, tetrahedron.positions);
    EXPECT_EQ(result.alone_area_share, 1);
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
