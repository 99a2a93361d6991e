#include "client/viewer/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "codec/mesh/semi_regular.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

struct Pixel {
    int r, g, b;
};

Pixel pixel(const Image& image, unsigned x, unsigned y) {
    const std::uint8_t* p = &image.rgb[(std::size_t{y} * image.width + x) * 3];
    return {p[0], p[1], p[2]};
}

std::size_t count(const Image& image, const std::function<bool(Pixel)>& is) {
    std::size_t n = 0;
    for (unsigned y = 0; y < image.height; ++y)
        for (unsigned x = 0; x < image.width; ++x) n += is(pixel(image, x, y)) ? 1 : 0;
    return n;
}

bool is_red(Pixel p) {
    return 5 * p.r > 8 * p.g && 5 * p.r > 8 * p.b;
}

PictureOptions small() {
    PictureOptions options;
    options.width = 200;
    options.height = 150;
    return options;
}

Image draw(const Mesh& mesh, const PictureOptions& options) {
    auto image = draw_picture(mesh, options);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    return image.ok() ? *image : Image{};
}

TEST(Picture, HasTheSizeAskedForAndTheModelInItsMiddle) {
    const Image image = draw(icosphere(3), small());
    ASSERT_EQ(image.rgb.size(), 200u * 150u * 3u);
    const Pixel middle = pixel(image, 100, 75), corner = pixel(image, 2, 2);
    EXPECT_LT(middle.b, middle.r);  // clay
    EXPECT_GE(corner.b, corner.r);  // background
    EXPECT_EQ(count(image, is_red), 0u);
}

TEST(Picture, IsTheSameEveryTime) {
    EXPECT_EQ(draw(torus(40, 20), small()).rgb, draw(torus(40, 20), small()).rgb);
}

TEST(Picture, ShowsFlippedTrianglesInRed) {
    Mesh mesh = icosphere(2);
    for (std::size_t f = 0; f < mesh.faces.size(); f += 8) std::swap(mesh.faces[f][0], mesh.faces[f][1]);
    EXPECT_GT(count(draw(mesh, small()), is_red), 300u);
}

std::size_t red_pixels(const Mesh& mesh, bool backs_in_place, double pitch = 15) {
    PictureOptions options = small();
    options.backs_in_place = backs_in_place;
    options.pitch = pitch;
    return count(draw(mesh, options), is_red);
}

TEST(Picture, HidesBacksOfFoldedSolids) {
    Mesh mesh = icosphere(1);
    mesh.positions[0] = mesh.positions[0] * -1.5;  // out through the other side, its faces inside out
    EXPECT_GT(red_pixels(mesh, true), 20u);
    EXPECT_EQ(red_pixels(mesh, false), 0u);
}

TEST(Picture, HidesBacksCloseAboveAnOpenSurface) {
    const auto flake_above = [](double height) {  // a square that looks up, a smaller one that looks down
        return mesh_of({{-1, 0, 1},
                        {1, 0, 1},
                        {1, 0, -1},
                        {-1, 0, -1},
                        {-0.5, height, 0.5},
                        {-0.5, height, -0.5},
                        {0.5, height, -0.5},
                        {0.5, height, 0.5}},
                       {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
    };
    EXPECT_GT(red_pixels(flake_above(0.005), true, 60), 500u);
    EXPECT_EQ(red_pixels(flake_above(0.005), false, 60), 0u);
    EXPECT_GT(red_pixels(flake_above(0.05), false, 60), 500u);
}

TEST(Picture, ShowsTheInsideOfWhatIsOpenOrTurnedInsideOut) {
    Mesh open = icosphere(3), turned = icosphere(3);
    std::erase_if(open.faces, [&](const Face& f) { return open.positions[f[0]].y > 0.5; });
    EXPECT_GT(red_pixels(open, false, 60), 1000u);
    for (Face& f : turned.faces) std::swap(f[0], f[1]);
    EXPECT_GT(red_pixels(turned, false), 5000u);
}

TEST(Picture, ShowsTheInsideOfASolidFromInside) {
    Mesh mesh = icosphere(3);
    const Mesh other = moved(mesh, {0, 0, -4});
    for (const Face& f : other.faces) mesh.faces.push_back({f[0] + 642, f[1] + 642, f[2] + 642});
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    PictureOptions options = small();
    options.camera = Camera{.eye = {0, 0, 0.5}};  // in the nearer sphere, towards the other one
    EXPECT_GT(count(draw(mesh, options), is_red), 20000u);
}

TEST(Picture, FillsThePictureWhereverTheModelIsAndHoweverLarge) {
    const Image reference = draw(torus(40, 20), small());
    for (const Mesh& mesh :
         {scaled(torus(40, 20), 1e30), scaled(torus(40, 20), 1e-30), moved(torus(40, 20), {1e6, 1e6, -1e6})}) {
        const Image image = draw(mesh, small());
        std::size_t different = 0;
        for (std::size_t i = 0; i < image.rgb.size(); ++i)
            different += std::abs(image.rgb[i] - reference.rgb[i]) > 8 ? 1 : 0;
        EXPECT_LT(different, 300u);
    }
}

TEST(Picture, UsesTheVertexColors) {
    Mesh mesh = icosphere(3);
    mesh.colors.assign(mesh.positions.size(), Rgba8{20, 200, 30, 255});
    const Image image = draw(mesh, small());
    EXPECT_GT(count(image, [](Pixel p) { return p.g > 2 * p.r && p.g > 2 * p.b; }), 3000u);
}

TEST(Picture, WireframeDarkensTheEdgesAlone) {
    PictureOptions options = small();
    const auto is_dark = [](Pixel p) { return p.r + p.g + p.b < 330; };
    const std::size_t plain = count(draw(icosphere(1), options), is_dark);
    options.wireframe = true;
    const std::size_t wire = count(draw(icosphere(1), options), is_dark);
    EXPECT_GT(wire, plain + 200);
    EXPECT_LT(wire, plain + 6000);
}

TEST(Picture, DrawsLinesOverTheSurfaceAndHidesThoseBehind) {
    PictureOptions options = small();
    options.yaw = options.pitch = 0;
    const Image plain = draw(icosphere(2), options);
    const auto changed = [&](const std::vector<Vec3>& line) {
        options.lines = {line};
        const Image image = draw(icosphere(2), options);
        std::size_t n = 0;
        for (std::size_t i = 0; i < image.rgb.size(); i += 3) n += image.rgb[i] + 40 < plain.rgb[i] ? 1 : 0;
        return n;
    };
    EXPECT_GT(changed({{-0.5, 0, 1}, {0.5, 0, 1}}), 50u);
    EXPECT_EQ(changed({{-0.5, 0, -1}, {0.5, 0, -1}}), 0u);
}

TEST(Picture, OneCameraSeesSeveralMeshesFromOnePlace) {
    PictureOptions options = small();
    options.camera = fit_camera(icosphere(3), 30, 15, 200.0 / 150.0);
    const Image all = draw(icosphere(3), options), half = draw(scaled(icosphere(3), 0.5), options);
    const auto is_model = [](Pixel p) { return p.b < p.r - 3; };
    EXPECT_NEAR(static_cast<double>(count(half, is_model)) / static_cast<double>(count(all, is_model)), 0.25, 0.05);
}

TEST(Picture, DrawsMeshesOfNoExtentAndNoFaces) {
    draw(Mesh{}, small());
    draw(mesh_of({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}), small());
}

TEST(Picture, RefusesSidesOutOfRangeAndPointsThatAreNotFinite) {
    PictureOptions options = small();
    options.width = 0;
    EXPECT_EQ(draw_picture(unit_cube(), options).error().code, Errc::InvalidArgument);
    options.width = kMaxPictureSide + 1;
    EXPECT_EQ(draw_picture(unit_cube(), options).error().code, Errc::InvalidArgument);
    Mesh mesh = unit_cube();
    mesh.positions[0].x = std::nan("");
    EXPECT_EQ(draw_picture(mesh, small()).error().code, Errc::InvalidArgument);
}

TEST(Camera, HasEveryVertexInThePictureAndTouchesItsMargin) {
    const Mesh mesh = moved(scaled(torus(50, 20), 3), {10, 20, 30});
    for (const double pitch : {-80.0, 0.0, 35.0}) {
        const Camera c = fit_camera(mesh, 70, pitch, 1.5);
        const double slope = std::tan(Camera::kFieldOfView / 2 * 3.14159265358979 / 180);
        double reach = 0;
        for (const Vec3& p : mesh.positions) {
            const Vec3 d = p - c.eye;
            const double depth = -dot(d, c.backward());
            reach = std::max({reach, std::abs(dot(d, c.up())) / (depth * slope),
                              std::abs(dot(d, c.right())) / (depth * slope * 1.5)});
        }
        EXPECT_LT(reach, 0.96);
        EXPECT_GT(reach, 0.92);
    }
}

TEST(HeatColors, RunFromBlueToRed) {
    const std::vector<Rgba8> colors = heat_colors({0, 0.5, 1, 7}, 1);
    EXPECT_GT(colors[0].b, colors[0].r);
    EXPECT_GT(colors[1].g, colors[1].r);
    EXPECT_GT(colors[2].r, colors[2].b);
    EXPECT_EQ(colors[2], colors[3]);
}

TEST(BaseEdgeLines, RunFromVertexToVertexThroughTheGrid) {
    const BaseMesh base = BaseMesh::create(4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}).value();
    std::vector<Vec3> positions(vertices_at_level(base, 2));
    for (std::size_t v = 0; v < positions.size(); ++v) positions[v].x = static_cast<double>(v);
    const auto lines = base_edge_lines(base, 2, positions);
    ASSERT_EQ(lines.size(), 6u);
    for (std::uint32_t e = 0; e < 6; ++e) {
        ASSERT_EQ(lines[e].size(), 5u);
        EXPECT_EQ(lines[e].front().x, base.edges()[e].v[0]);
        EXPECT_EQ(lines[e].back().x, base.edges()[e].v[1]);
        EXPECT_EQ(lines[e][2].x, 4 + e);  // level 1's midpoint
    }
}

}  // namespace
}  // namespace mvw
