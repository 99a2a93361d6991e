#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "codec/decoder.h"
#include "codec/encoder.h"
#include "codec/measure/surface_index.h"
#include "codec/mesh/half_edges.h"
#include "codec/remesh/features.h"
#include "codec/remesh/recognize.h"
#include "codec/remesh/remesh.h"
#include "tests/support/meshes.h"
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
    const EdgeGroups groups = group_edges(mesh.faces, static_cast<std::uint32_t>(mesh.positions.size()));
    std::size_t borders = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const std::uint32_t h = groups[g][0], twin = groups[g][1];
        const bool is_border = mesh.materials[h / 3] != mesh.materials[twin / 3];
        borders += is_border ? 1 : 0;
        EXPECT_EQ(flags[h], is_border ? 1 : 0);
        EXPECT_EQ(flags[twin], flags[h]);
    }
    EXPECT_GT(borders, 2u * 48);
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

TEST(Materials, ABaseFaceOfSemiRegularInputHasOne) {
    Mesh mesh = plain(bumpy_ball(5));
    // A quarter of base face 0, its last rows, is of another material.
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) mesh.materials.push_back(f >= 768 && f < 1024 ? 2 : 1);
    const Recognition quarters = recognize(mesh, 1);
    ASSERT_EQ(quarters.meshes.size(), 1u);
    EXPECT_EQ(quarters.meshes[0].levels, 4u);
    const std::vector<std::uint32_t>& materials = quarters.meshes[0].materials;
    EXPECT_EQ(materials.size(), quarters.meshes[0].base.face_count());
    EXPECT_EQ(std::count(materials.begin(), materials.end(), 2u), 1);
}

TEST(Materials, OneComponentWithBordersAcrossItsFacesLeavesTheOthersAsTheyAre) {
    Mesh mesh = plain(bumpy_ball(5));
    for (const Face& f : mesh.faces) mesh.materials.push_back(center(mesh, f).z > 0.2 ? 1 : 0);
    Mesh other = moved(plain(bumpy_ball(3)), {5, 0, 0});
    other.materials.assign(other.faces.size(), 3);
    const RemeshResult result = remesh(join(mesh, other), {});
    EXPECT_EQ(std::count(result.origins.begin(), result.origins.end(), PartOrigin::Recognized), 1);
    EXPECT_EQ(std::count(result.origins.begin(), result.origins.end(), PartOrigin::Remeshed), 1);
    for (const SemiRegularMesh& part : result.parts) EXPECT_EQ(part.materials.size(), part.base.face_count());
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
