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
    return choose_facets(mesh, component_of_face, count, [](std::uint32_t) { return true; });
}

TEST(Facets, HaveNoDetails) {
    for (const Mesh& mesh : {tetrahedron_mesh(), unit_cube(), icosphere(2)}) {
        const SemiRegularMesh part = facets_of(mesh);
        EXPECT_EQ(part.base.faces(), mesh.faces);
        std::vector<Vec3f> positions(part.positions.size()), details(part.positions.size());
        std::transform(part.positions.begin(), part.positions.end(), positions.begin(), to_float);
        PatchTransform(part.base, part.levels, {}, part.creases).analyze(positions, details);
        for (std::size_t v = part.base.vertex_count(); v < details.size(); ++v)
            EXPECT_LT(length(to_double(details[v])), 1e-6) << mesh.faces.size() << " faces, vertex " << v;
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
        EXPECT_LT(own.file.size(), 1.06 * alone.file.size()) << name;
    }
}

}  // namespace
}  // namespace mvw
