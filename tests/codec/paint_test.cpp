#include "codec/enc_paint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "codec/decoder.h"
#include "codec/encoder.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/material_colors.h"
#include "codec/mesh/srgb.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// A surface whose points have the colour of where they lie.
class Pattern : public Paintwork {
 public:
    using Color = std::array<double, 4> (*)(const Vec3&);
    Pattern(Mesh surface, Color color) : surface_(std::move(surface)), color_(color) {}
    [[nodiscard]] const Mesh& surface() const override { return surface_; }
    [[nodiscard]] std::array<double, 4> at(std::uint32_t face, const std::array<double, 3>& weights) const override {
        Vec3 p;
        for (std::size_t c = 0; c < 3; ++c) p += surface_.positions[surface_.faces[face][c]] * weights[c];
        return color_(p);
    }

 private:
    const Mesh surface_;
    const Color color_;
};

/// Squares of a quarter, black and white.
std::array<double, 4> chequers(const Vec3& p) {
    const auto row = [](double x) { return static_cast<long>(std::floor(4 * x)); };
    return (row(p.x) + row(p.y)) % 2 == 0 ? std::array<double, 4>{0, 0, 0, 1} : std::array<double, 4>{1, 1, 1, 1};
}
std::array<double, 4> fine_chequers(const Vec3& p) {
    return chequers(p * 4001.3);
}
std::array<double, 4> one_red(const Vec3&) {
    return {0.5, 0, 0, 1};
}

Mesh square(Pattern::Color color) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}, {0, 2, 3}};
    mesh.paintwork = std::make_shared<Pattern>(mesh, color);
    return mesh;
}

Encoded encoded(const Mesh& mesh, EncodeOptions options = {}) {
    options.threads = 2;
    return encode(mesh, options).value();
}

TEST(Paint, WhatLiesBetweenVerticesIsThere) {
    const Encoded coded = encoded(square(chequers));
    EXPECT_GT(coded.color_levels, 3u);
    const Mesh mesh = decode(coded.file).value();
    ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
    const double edge = std::ldexp(1.0, -static_cast<int>(coded.levels));
    std::size_t seen = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3& p = mesh.positions[v];
        const auto from_border = [](double x) { return std::abs(4 * x - std::round(4 * x)) / 4; };
        if (std::min(from_border(p.x), from_border(p.y)) < 2 * edge) continue;
        EXPECT_NEAR(mesh.colors[v].g, chequers(p)[1] > 0 ? 255 : 0, 12) << p.x << " " << p.y;
        ++seen;
    }
    EXPECT_GT(seen, mesh.positions.size() / 2);
    EXPECT_GT(coded.psnr, 100) << "the square stays flat";
}

TEST(Paint, APatternTooFineIsItsMean) {
    const Encoded coded = encoded(square(fine_chequers));
    const Mesh mesh = decode(coded.file).value();
    EXPECT_LE(mesh.positions.size(), 1'048'576u);
    double sum = 0;
    for (const Rgba8& c : mesh.colors) sum += to_linear(c)[0] / static_cast<double>(mesh.colors.size());
    EXPECT_NEAR(sum, 0.5, 0.05);
}

TEST(Paint, NoLevelsWhereVerticesShowItAllOrNoneAreWanted) {
    EXPECT_EQ(encoded(square(one_red)).color_levels, 0u);
    EncodeOptions options;
    options.color_levels = false;
    const Encoded coded = encoded(square(chequers), options);
    EXPECT_EQ(coded.color_levels, 0u);
    EXPECT_FALSE(decode(coded.file).value().colors.empty());
    options = {};
    options.levels = 2;
    EXPECT_EQ(encoded(square(chequers), options).levels, 2u);
}

TEST(Paint, TheSurfaceAndItsFieldsStayAsTheyAre) {
    Mesh mesh = torus(67, 31);  // no subdivision connectivity
    VertexField height{FieldKind::Scalar, "height", {}};
    for (const Vec3& p : mesh.positions) height.values.push_back(p.z);
    mesh.fields.push_back(height);
    const Encoded plain = encoded(mesh);
    mesh.paintwork = std::make_shared<Pattern>(mesh, chequers);
    const Encoded painted = encoded(mesh);
    EXPECT_GT(painted.color_levels, 0u);
    EXPECT_NEAR(painted.psnr, plain.psnr, 1);
    const Mesh decoded = decode(painted.file).value();
    ASSERT_EQ(decoded.fields.size(), 1u);
    for (std::size_t v = 0; v < decoded.positions.size(); ++v)
        EXPECT_NEAR(decoded.fields[0].values[v], decoded.positions[v].z, 0.05);
}

TEST(Paint, BeginningsAreOfTheLevelThatTheirColoursHave) {
    const Encoded coded = encoded(square(chequers));
    Decoder decoder;
    ASSERT_TRUE(decoder.feed(ByteSpan(coded.file).first(coded.file.size() * 3 / 4)).ok());
    EXPECT_FALSE(decoder.state().complete);
    EXPECT_GE(decoder.state().level + 1, coded.levels);
}

TEST(Paint, MaterialsWithoutImagesStaySharpBesideThem) {
    Mesh mesh = square(chequers);
    const Mesh ball = moved(torus(67, 31), {5, 0, 0});
    mesh.materials = {0, 0};
    mesh.materials.resize(2 + ball.faces.size(), 1);
    const std::shared_ptr<const Paintwork> paintwork = mesh.paintwork;
    const std::vector<std::uint32_t> labels = mesh.materials;
    mesh.materials.clear();
    mesh = join(mesh, ball);
    mesh.materials = labels;
    mesh.material_colors = {{1, {9, 8, 7, 255}}};
    mesh.colors.assign(mesh.positions.size(), {});
    mesh.paintwork = paintwork;
    const Encoded coded = encoded(mesh);
    EXPECT_EQ(coded.material_colors, 1u);
    EXPECT_LT(coded.painted_vertices, coded.vertices);
    Mesh decoded = decode(coded.file).value();
    (void)colors_to_vertices(decoded);
    std::set<int> greens;
    for (std::size_t f = 0; f < decoded.faces.size(); ++f)
        for (const std::uint32_t v : decoded.faces[f]) {
            if (decoded.materials[f] == 1) {
                ASSERT_EQ(decoded.colors[v], (Rgba8{9, 8, 7, 255}));
            } else {
                greens.insert(decoded.colors[v].g / 128);
            }
        }
    EXPECT_EQ(greens.size(), 2u);
}

TEST(Paint, SpotHasItsCoatBetweenVertices) {
    MVW_SKIP_WITHOUT_MODELS();
    CleanReport report;
    const std::string folder = models_folder() + "/spot/";
    const Mesh spot = read_mesh(folder + "spot_triangulated.obj", report, folder + "spot_texture.png").value();
    const Mesh mesh = decode(encoded(spot).file).value();
    const SurfaceIndex index(spot.paintwork->surface().positions, spot.paintwork->surface().faces);
    // Against the image itself at the decoded vertices, and against what the input's vertices alone know of it.
    double error = 0, error_of_vertices = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const SurfacePoint at = index.closest(mesh.positions[v]);
        const double truth = to_srgb(spot.paintwork->at(at.face, at.barycentric)).g;
        double interpolated = 0;
        for (std::size_t c = 0; c < 3; ++c)
            interpolated += at.barycentric[c] * spot.colors[spot.paintwork->surface().faces[at.face][c]].g;
        error += std::pow(mesh.colors[v].g - truth, 2) / static_cast<double>(mesh.positions.size());
        error_of_vertices += std::pow(interpolated - truth, 2) / static_cast<double>(mesh.positions.size());
    }
    EXPECT_LT(error, error_of_vertices / 4);
    EXPECT_LT(std::sqrt(error), 10) << "of 255";
}

}  // namespace
}  // namespace mvw
