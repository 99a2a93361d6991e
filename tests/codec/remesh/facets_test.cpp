#include "codec/remesh/facets.h"

#include <gtest/gtest.h>

#include "codec/decoder.h"
#include "codec/encoder.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "codec/transform/transform.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// Flags of components that may be their own bases.
std::vector<std::uint8_t> chosen(const Mesh& mesh) {
    std::vector<std::uint32_t> component_of_face;
    const std::size_t count = components(mesh, component_of_face).size();
    return choose_facets(mesh, component_of_face, count, false, [](std::uint32_t) { return true; });
}

double longest_edge(const Mesh& mesh) {
    double most = 0;
    for (const Face& f : mesh.faces)
        for (unsigned c = 0; c < 3; ++c)
            most = std::max(most, length(mesh.positions[f[c]] - mesh.positions[f[(c + 1) % 3]]));
    return most;
}

double largest_detail(const SemiRegularMesh& part) {
    std::vector<Vec3f> positions(part.positions.size()), details(part.positions.size());
    std::transform(part.positions.begin(), part.positions.end(), positions.begin(), to_float);
    PatchTransform(part.base, part.levels, {}, part.creases).analyze(positions, details);
    double most = 0;
    for (std::size_t v = part.base.vertex_count(); v < details.size(); ++v)
        most = std::max(most, length(to_double(details[v])));
    return most;
}

TEST(Facets, HaveNoDetails) {
    for (const Mesh& mesh : {tetrahedron_mesh(), unit_cube(), icosphere(2)}) {
        const SemiRegularMesh part = facets_of(mesh);
        EXPECT_EQ(part.base.faces(), mesh.faces);
        EXPECT_LT(largest_detail(part), 1e-6) << mesh.faces.size() << " faces";
    }
}

TEST(Facets, KeepColoursAndMaterials) {
    Mesh mesh = tetrahedron_mesh();
    mesh.colors = {{0, 0, 0, 255}, {200, 0, 0, 255}, {0, 100, 0, 255}, {0, 0, 50, 255}};
    mesh.materials = {0, 1, 1, 0};
    const SemiRegularMesh part = facets_of(mesh);
    EXPECT_EQ(part.materials, mesh.materials);
    ASSERT_EQ(part.colors.size(), part.positions.size());
    const BaseEdge& first = part.base.edges()[0];
    const int middle = (mesh.colors[first.v[0]].r + mesh.colors[first.v[1]].r) / 2;
    EXPECT_NEAR(part.colors[edge_vertex_index(part.base, first, 1, 1)].r, middle, 1);
}

TEST(Facets, LargeFacesAreSplitWhereTheyAreInTheSurface) {
    Mesh box = unit_cube();
    for (Vec3& p : box.positions) p.x *= 10;
    for (const Mesh& mesh : {box, unit_square(), join(tetrahedron_mesh(), without_sharing(unit_square()))}) {
        Mesh split = mesh;
        const double longest = bounding_box(mesh).diagonal() / 8;
        split_large_faces(split, longest);
        EXPECT_TRUE(is_clean_manifold(split));
        EXPECT_GT(split.faces.size(), mesh.faces.size());
        EXPECT_LE(split.faces.size(), mesh.faces.size() * 3 + 70);
        EXPECT_LT(surface_error(mesh, split, {10'000, 1}).max, 1e-12);
        EXPECT_LT(longest_edge(split), 0.55 * longest_edge(mesh)) << mesh.faces.size();
        // No details, though some of the input's vertices have one face.
        EXPECT_LT(largest_detail(facets_of(split)), 1e-5);
    }
}

TEST(Facets, AreNotForManyFacesOrForLooseTriangles) {
    EXPECT_EQ(chosen(tetrahedron_mesh()), std::vector<std::uint8_t>{1});
    EXPECT_EQ(chosen(icosphere(4)), std::vector<std::uint8_t>{0});
    EXPECT_EQ(chosen(join(without_sharing(unit_cube()), unit_cube())),
              (std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}));
    Mesh many = icosphere(2);  // 320 faces
    for (int k = 0; k < 6; ++k) many = join(many, many);
    EXPECT_EQ(chosen(many), std::vector<std::uint8_t>(64, 0)) << "20,480 faces together";
}

TEST(Facets, AreCodedAsWellAsByDracoAloneInAboutAsManyBytes) {
    MVW_SKIP_WITHOUT_MODELS();
    EncodeOptions as_it_is;
    as_it_is.levels = 0;
    for (const char* name : {"spot/spot_control_mesh.obj", "milktruck.glb"}) {
        const Mesh mesh = clean_model(name);
        const Encoded own = encode(mesh, {}).value(), alone = encode(mesh, as_it_is).value();
        EXPECT_EQ(own.draco_area_share, 0) << name;
        EXPECT_GT(own.facets_area_share, 0.9) << name;
        EXPECT_EQ(alone.draco_area_share, 1) << name;
        EXPECT_GT(own.psnr, alone.psnr) << name;
        EXPECT_LT(own.file.size(), 1.09 * alone.file.size()) << name;
    }
}

}  // namespace
}  // namespace mvw
