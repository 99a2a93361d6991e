#include "codec/remesh/materials.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "codec/decoder.h"
#include "codec/encoder.h"
#include "codec/measure/surface_index.h"
#include "codec/remesh/features.h"
#include "codec/remesh/remesh.h"
#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

Vec3 center(const Mesh& mesh, const Face& f) {
    return (mesh.positions[f[0]] + mesh.positions[f[1]] + mesh.positions[f[2]]) / 3.0;
}

/// A torus in three materials: two halves, and a patch on one of them.
Mesh painted_torus() {
    Mesh mesh = torus(90, 48);
    for (const Face& f : mesh.faces) {
        const Vec3 c = center(mesh, f);
        mesh.materials.push_back(length(c - Vec3{1, 0, 0.4}) < 0.35 ? 7 : c.x > 0 ? 2 : 5);
    }
    return mesh;
}

std::map<std::uint32_t, double> area_by_material(const Mesh& mesh) {
    std::map<std::uint32_t, double> area;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Vec3& a = mesh.positions[mesh.faces[f][0]];
        area[mesh.materials[f]] +=
            length(cross(mesh.positions[mesh.faces[f][1]] - a, mesh.positions[mesh.faces[f][2]] - a)) / 2;
    }
    return area;
}

/// Share of the faces of `mesh` whose material is not that of the input's face below their centre.
double share_in_wrong_place(const Mesh& input, const Mesh& mesh) {
    const SurfaceIndex index(input.positions, input.faces, 1);
    double wrong = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        wrong += input.materials[index.closest(center(mesh, mesh.faces[f])).face] != mesh.materials[f];
    return wrong / double(mesh.faces.size());
}

TEST(Materials, BordersAreFeatures) {
    const Mesh mesh = painted_torus();
    const std::vector<std::uint8_t> flags = feature_half_edges(mesh);
    Mesh plain_torus = mesh;
    plain_torus.materials.clear();
    for (const std::uint8_t flag : feature_half_edges(plain_torus)) ASSERT_EQ(flag, 0) << "nothing else is";
    EXPECT_GT(std::count(flags.begin(), flags.end(), 1), 2 * 2 * 48);
}

TEST(Materials, OfSemiRegularInputStayWithItsBaseFaces) {
    Mesh mesh = plain(bumpy_ball(3));
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) mesh.materials.push_back(f >> 6u);
    const RemeshResult result = remesh(mesh, {});
    ASSERT_EQ(result.origins, std::vector{PartOrigin::Recognized});
    const SemiRegularMesh& part = result.parts[0];
    ASSERT_EQ(part.materials.size(), part.base.face_count());
    Mesh finest = finest_mesh(result.parts);
    for (std::uint32_t f = 0; f < finest.faces.size(); ++f)
        finest.materials.push_back(part.materials[f >> (2 * part.levels)]);
    EXPECT_EQ(share_in_wrong_place(mesh, finest), 0);
}

TEST(Materials, SemiRegularInputWithBordersAcrossBaseFacesIsRemeshed) {
    Mesh mesh = plain(bumpy_ball(5));
    for (const Face& f : mesh.faces) mesh.materials.push_back(center(mesh, f).z > 0.2 ? 1 : 0);
    const RemeshResult result = remesh(mesh, {});
    ASSERT_EQ(result.origins, std::vector{PartOrigin::Remeshed});
    EXPECT_EQ(result.parts[0].materials.size(), result.parts[0].base.face_count());
}

TEST(Materials, SurviveRemeshingAndCodingInTheirPlaces) {
    const Mesh mesh = painted_torus();
    EncodeOptions options;
    options.levels = 3;  // no trials
    const auto encoded = encode(mesh, options);
    ASSERT_TRUE(encoded.ok());
    EXPECT_EQ(encoded->draco_area_share, 0);
    EXPECT_EQ(encoded->facets_area_share, 0);
    const auto decoded = decode(encoded->file);
    ASSERT_TRUE(decoded.ok());
    ASSERT_EQ(decoded->materials.size(), decoded->faces.size());
    const auto before = area_by_material(mesh), after = area_by_material(*decoded);
    ASSERT_EQ(after.size(), 3u);
    for (const auto& [material, area] : before)
        EXPECT_NEAR(after.at(material), area, 0.02 * area) << "material " << material;
    EXPECT_LT(share_in_wrong_place(mesh, *decoded), 0.03);
    const auto base = decode(encoded->file, 0);
    ASSERT_TRUE(base.ok());
    EXPECT_EQ(area_by_material(*base).size(), 3u) << "from the base on";
}

}  // namespace
}  // namespace mvw
