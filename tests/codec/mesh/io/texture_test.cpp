#include "codec/mesh/io/texture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb_image_write.h>
#include <webp/encode.h>

#include <cmath>
#include <filesystem>

#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/io/text.h"
#include "codec/mesh/material_colors.h"
#include "codec/mesh/paintwork.h"
#include "codec/mesh/srgb.h"
#include "tests/support/models.h"
#include "tests/support/program.h"

namespace mvw {
namespace {

using ::testing::HasSubstr;

void append(void* to, void* data, int size) {
    const auto* begin = static_cast<const std::byte*>(data);
    static_cast<Bytes*>(to)->insert(static_cast<Bytes*>(to)->end(), begin, begin + size);
}

/// Two by two texels: red, green above; blue, half-transparent white below.
Bytes small_png() {
    const std::uint8_t texels[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128};
    Bytes file;
    stbi_write_png_to_func(append, &file, 2, 2, 4, texels, 8);
    return file;
}

std::array<int, 4> bytes_at(const Texture& t, double u, double v, Texture::Wrap wrap = Texture::Wrap::Repeat) {
    const std::array<double, 4> c = t.at(u, v, wrap, wrap);
    return {to_byte(to_srgb(c[0])), to_byte(to_srgb(c[1])), to_byte(to_srgb(c[2])), to_byte(c[3])};
}

TEST(Texture, TexelsAreWhereGltfSaysAndLightMixesBetweenThem) {
    const Texture t = Texture::decode(small_png()).value();
    using Texel = std::array<int, 4>;
    EXPECT_EQ(bytes_at(t, 0.25, 0.25), (Texel{255, 0, 0, 255}));
    EXPECT_EQ(bytes_at(t, 0.75, 0.25), (Texel{0, 255, 0, 255}));
    EXPECT_EQ(bytes_at(t, 0.25, 0.75), (Texel{0, 0, 255, 255}));
    EXPECT_EQ(bytes_at(t, 0.75, 0.75), (Texel{255, 255, 255, 128}));
    EXPECT_EQ(bytes_at(t, 0.5, 0.25), (Texel{188, 188, 0, 255})) << "half of the light is sRGB 188";
    EXPECT_EQ(bytes_at(t, 1.25, -0.75), (Texel{255, 0, 0, 255})) << "repeated";
    EXPECT_EQ(bytes_at(t, 1.25, 0.25, Texture::Wrap::Mirror), (Texel{0, 255, 0, 255}));
    EXPECT_EQ(bytes_at(t, 9, 0.25, Texture::Wrap::Clamp), (Texel{0, 255, 0, 255}));
    EXPECT_EQ(bytes_at(t, std::nan(""), 1e300), (Texel{0, 0, 0, 0}));
}

/// The small image in WebP.
Bytes small_webp() {
    const std::uint8_t texels[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128};
    std::uint8_t* file = nullptr;
    const std::size_t size = WebPEncodeLosslessRGBA(texels, 2, 2, 8, &file);
    const auto* begin = reinterpret_cast<const std::byte*>(file);
    Bytes bytes(begin, begin + size);
    WebPFree(file);
    return bytes;
}

TEST(Texture, WebpIsDecodedAndItsSizeChecked) {
    const Texture t = Texture::decode(small_webp()).value();
    EXPECT_EQ(bytes_at(t, 0.25, 0.25), (std::array<int, 4>{255, 0, 0, 255}));
    EXPECT_EQ(bytes_at(t, 0.75, 0.75), (std::array<int, 4>{255, 255, 255, 128}));
    Bytes cut = small_webp();
    cut.resize(cut.size() - 8);
    EXPECT_FALSE(Texture::decode(cut).ok());
    // A lossless image of 16,384 by 16,384: 14 bits each, less one, behind the signature.
    Bytes huge = small_webp();
    for (const std::size_t at : {21u, 22u, 23u}) huge[at] = std::byte{0xFF};
    EXPECT_EQ(Texture::decode(huge).error().code, Errc::LimitExceeded);
}

TEST(Texture, OnlyPngAndJpegOfPlausibleSizeAreDecoded) {
    EXPECT_EQ(Texture::decode(as_bytes("GIF89a")).error().code, Errc::Unsupported);
    EXPECT_EQ(Texture::decode({}).error().code, Errc::Unsupported);
    Bytes cut = small_png();
    cut.resize(40);
    EXPECT_FALSE(Texture::decode(cut).ok());
    // The header of an image of 8,000 by 8,000 in front of next to nothing.
    Bytes huge = small_png();
    for (const std::size_t at : {16u, 20u}) huge[at + 2] = std::byte{0x1F}, huge[at + 3] = std::byte{0x40};
    EXPECT_EQ(Texture::decode(huge).error().code, Errc::LimitExceeded);
    const std::uint8_t grey[192] = {};
    Bytes jpeg;
    stbi_write_jpg_to_func(append, &jpeg, 8, 8, 3, grey, 90);
    EXPECT_EQ(Texture::decode(jpeg).value().pixels(), 64u);
}

/// A folder with an OBJ of two triangles over the small image, along whose common edge the image is cut.
class TexturedObj : public ::testing::Test {
 protected:
    void SetUp() override {
        folder_ = std::filesystem::path(::testing::TempDir()) /
                  ("mvw_textured_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        write("image.png", small_png());
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    void write(const std::string& name, ByteSpan bytes) { ASSERT_TRUE(write_file(path(name), bytes).ok()); }
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

    Result<Mesh> read(const std::string& head, const std::string& mtl, const std::string& texture = {}) {
        write("a.mtl", as_bytes(mtl));
        // v runs upwards in OBJ: (.25, .75) is red, (.75, .75) green, (.25, .25) blue.
        write("a.obj", as_bytes(head + "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt .25 .75\nvt .75 .75\nvt .25 .25\n"
                                       "usemtl m\nf 1/1 2/1 3/1\nf 2/2 4/3 3/1\n"));
        report_ = {};
        return read_mesh(path("a.obj"), report_, texture);
    }

    std::filesystem::path folder_;
    CleanReport report_;
};

TEST_F(TexturedObj, VerticesTakeTheImagesColourTimesTheMaterials) {
    const Mesh white = read("mtllib a.mtl\n", "newmtl m\nmap_Kd image.png\n").value();
    ASSERT_EQ(white.colors.size(), 4u);
    EXPECT_EQ(white.colors[0], (Rgba8{255, 0, 0, 255}));
    EXPECT_EQ(white.colors[3], (Rgba8{0, 0, 255, 255}));
    EXPECT_EQ(white.colors[1], (Rgba8{188, 188, 0, 255})) << "on the seam: the mean of red and green light";
    EXPECT_EQ(report_.textured_vertices, 4u);
    const Mesh half = read("mtllib a.mtl\n", "newmtl m\nKd .4 1 .8\nmap_Kd -s 1 1 1 image.png\n").value();
    ASSERT_EQ(half.colors.size(), 4u);
    EXPECT_EQ(half.colors[0], (Rgba8{102, 0, 0, 255}));
    EXPECT_EQ(half.colors[3], (Rgba8{0, 0, 204, 255}));
    const Mesh black = read("mtllib a.mtl\n", "newmtl m\nKd 0 0 0\nmap_Kd image.png\n").value();
    ASSERT_EQ(black.colors.size(), 4u);
    EXPECT_EQ(black.colors[0], (Rgba8{255, 0, 0, 255})) << "black is not meant";
}

TEST_F(TexturedObj, ColoursOfMaterialsAreKeptWithoutImages) {
    const Mesh red = read("mtllib a.mtl\n", "newmtl m\nKd 1 0 0\n").value();
    EXPECT_TRUE(red.colors.empty());
    EXPECT_EQ(red.material_colors, (std::vector<MaterialColor>{{0, {255, 0, 0, 255}}}));
    EXPECT_EQ(report_.textured_vertices, 0u);
    EXPECT_TRUE(read("mtllib a.mtl\n", "newmtl m\nKd .8 .8 .8\n").value().material_colors.empty()) << "one grey";
    // Half of the square red, the rest in the grey of a second one: on their border vertices take the mean, the
    // surface between them does not.
    write("two.mtl", as_bytes("newmtl m\nKd 1 0 0\nnewmtl n\nKd .5 .5 .5\n"));
    write("two.obj",
          as_bytes("mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl m\nf 1 2 3\nusemtl n\nf 2 4 3\n"));
    const Mesh two = read_mesh(path("two.obj"), report_).value();
    EXPECT_TRUE(two.colors.empty());
    EXPECT_EQ(two.paintwork, nullptr);
    EXPECT_EQ(two.material_colors, (std::vector<MaterialColor>{{two.materials[0], {255, 0, 0, 255}},
                                                               {two.materials[1], {128, 128, 128, 255}}}));
}

TEST_F(TexturedObj, CornersOfPolygonsKeepTheirPlacesInTheImage) {
    // A strip of four columns of the image's upper row, its six corners in one polygon; the two below have no place.
    write("hex.mtl", as_bytes("newmtl m\nmap_Kd image.png\n"));
    write("hex.obj", as_bytes("mtllib hex.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 0 1 0\n"
                              "vt .25 .75\nvt .5 .75\nvt .75 .75\nf 1/1 2/2 3/3 4/3 5 6/1\n"));
    const Mesh mesh = read_mesh(path("hex.obj"), report_).value();
    ASSERT_NE(mesh.paintwork, nullptr);
    ASSERT_EQ(mesh.faces.size(), 4u);
    const std::array<Rgba8, 6> expected{Rgba8{255, 0, 0, 255}, {188, 188, 0, 255},   {0, 255, 0, 255},
                                        {0, 255, 0, 255},      {255, 255, 255, 255}, {255, 0, 0, 255}};
    for (std::uint32_t f = 0; f < 4; ++f)
        for (std::size_t c = 0; c < 3; ++c) {
            std::array<double, 3> corner{};
            corner[c] = 1;
            EXPECT_EQ(to_srgb(mesh.paintwork->at(f, corner)), expected[mesh.faces[f][c]]) << f << " " << c;
        }
    for (std::size_t v = 0; v < 6; ++v) EXPECT_EQ(mesh.colors[v], expected[v]) << v;
}

TEST_F(TexturedObj, AnImageFromOutsideServesAFileThatNamesNone) {
    EXPECT_TRUE(read("", "").value().colors.empty());
    const Mesh mesh = read("", "", path("image.png")).value();
    ASSERT_EQ(mesh.colors.size(), 4u);
    EXPECT_EQ(mesh.colors[0], (Rgba8{255, 0, 0, 255}));
    EXPECT_FALSE(read("", "", path("nowhere.png")).ok());
}

TEST_F(TexturedObj, WhatCannotBeReadIsNamedAndTheMeshReadAllTheSame) {
    EXPECT_TRUE(read("mtllib a.mtl\n", "newmtl m\nmap_Kd nowhere.png\n").value().colors.empty());
    ASSERT_EQ(report_.missing_textures.size(), 1u);
    EXPECT_THAT(report_.missing_textures[0], HasSubstr("nowhere.png"));
    EXPECT_TRUE(read("mtllib ../b.mtl\n", "").ok());
    ASSERT_EQ(report_.missing_textures.size(), 1u);
    EXPECT_THAT(report_.missing_textures[0], HasSubstr("outside"));
    write("image.png", as_bytes("no image"));
    EXPECT_TRUE(read("mtllib a.mtl\n", "newmtl m\nmap_Kd image.png\n").ok());
    EXPECT_EQ(report_.missing_textures.size(), 1u);
}

/// A GLB-like scene in JSON with its buffer and image beside it: three vertices, red, green and blue in the image.
std::string gltf_of(const std::string& material) {
    return R"({"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":60}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},
{"bufferView":1,"componentType":5126,"type":"VEC2","count":3}],
"images":[{"uri":"image.png"}],"textures":[{"source":0}],"materials":[{"pbrMetallicRoughness":)" +
           material + R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}]})";
}

TEST_F(TexturedObj, GltfsImagesFactorsAndTransformsColourVertices) {
    ByteWriter buffer;
    for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, .25f, .25f, .75f, .25f, .25f, .75f})
        buffer.f32(x);
    write("a.bin", buffer.view());
    const auto colors = [&](const std::string& material) {
        write("a.gltf", as_bytes(gltf_of(material)));
        report_ = {};
        Mesh mesh = read_mesh(path("a.gltf"), report_).value();
        (void)colors_to_vertices(mesh);
        std::vector<Rgba8> of_vertices = mesh.colors;
        of_vertices.resize(3);  // white where there are none
        return of_vertices;
    };
    const std::vector<Rgba8> none(3);
    const std::vector<Rgba8> plain = colors(R"({"baseColorTexture":{"index":0}})");
    EXPECT_EQ(plain[0], (Rgba8{255, 0, 0, 255}));
    EXPECT_EQ(plain[1], (Rgba8{0, 255, 0, 255}));
    EXPECT_EQ(plain[2], (Rgba8{0, 0, 255, 255}));
    EXPECT_EQ(colors(R"({"baseColorFactor":[0.5,1,1,0.5],"baseColorTexture":{"index":0}})")[0], (Rgba8{188, 0, 0, 255}))
        << "alpha is not meant where nothing is to be seen through";
    EXPECT_EQ(colors(R"({"baseColorFactor":[0.5,1,1,0.5],"baseColorTexture":{"index":0}},"alphaMode":"BLEND")")[0].a,
              128);
    EXPECT_EQ(
        colors(R"({"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0]}}}})")[0],
        (Rgba8{0, 255, 0, 255}));
    EXPECT_EQ(colors(R"({"baseColorFactor":[1,0,0,1]})")[1], (Rgba8{255, 0, 0, 255}));
    EXPECT_EQ(report_.textured_vertices, 0u) << "no image";
    EXPECT_EQ(colors(R"({"baseColorFactor":[0.5,0.5,0.5,1]})"), none) << "one grey tells nothing";
    // As web tools write it: WebP beside the image for others, or alone.
    write("image.webp", small_webp());
    for (const std::string texture : {R"({"source":0,"extensions":{"EXT_texture_webp":{"source":1}}})",
                                      R"({"extensions":{"EXT_texture_webp":{"source":1}}})"}) {
        std::string gltf = gltf_of(R"({"baseColorTexture":{"index":0}})");
        const auto put = [&](const std::string& at, const std::string& with) {
            gltf.replace(gltf.find(at), at.size(), with);
        };
        put(R"({"source":0})", texture);
        put(R"([{"uri":"image.png"}])", R"([{"uri":"nowhere.png"},{"uri":"image.webp"}])");
        write("webp.gltf", as_bytes(gltf));
        report_ = {};
        EXPECT_EQ(read_mesh(path("webp.gltf"), report_).value().colors, plain);
    }
    std::filesystem::remove(path("image.png"));
    EXPECT_EQ(colors(R"({"baseColorTexture":{"index":0}})"), none);
    EXPECT_EQ(report_.missing_textures.size(), 1u);
}

TEST(TexturedModels, AWebpInAGlbPaintsASquareAndAColourTheNextOne) {
    CleanReport report;
    const Mesh mesh = read_mesh(test_data_folder() + "/painted_webp.glb", report).value();
    ASSERT_NE(mesh.paintwork, nullptr);
    EXPECT_TRUE(report.missing_textures.empty());
    ASSERT_EQ(mesh.faces.size(), 4u);
    EXPECT_EQ(to_srgb(mesh.paintwork->at(2, {1, 0, 0})), (Rgba8{0, 0, 255, 255}));
    // The image's green rises with its rows; the factor halves its light.
    const auto green = [&](std::uint32_t face, std::size_t corner) {
        std::array<double, 3> at{};
        at[corner] = 1;
        return mesh.paintwork->at(face, at)[1];
    };
    EXPECT_LT(green(0, 0), 0.1);
    EXPECT_GT(green(1, 2), 0.25);
    EXPECT_LE(green(1, 2), 0.5);
}

TEST(TexturedModels, SpotsCoatIsThatOfItsImage) {
    MVW_SKIP_WITHOUT_MODELS();
    CleanReport report;
    const std::string folder = models_folder() + "/spot/";
    const Mesh spot = read_mesh(folder + "spot_triangulated.obj", report, folder + "spot_texture.png").value();
    ASSERT_EQ(spot.colors.size(), 2930u);
    // Vertices amid texels of one colour: coat, muzzle, spots, horns, hoofs.
    EXPECT_EQ(spot.colors[2], (Rgba8{255, 238, 230, 255}));
    EXPECT_EQ(spot.colors[39], (Rgba8{255, 198, 167, 255}));
    EXPECT_EQ(spot.colors[4], (Rgba8{64, 64, 64, 255}));
    EXPECT_EQ(spot.colors[81], (Rgba8{157, 90, 53, 255}));
    EXPECT_EQ(spot.colors[42], (Rgba8{104, 104, 104, 255}));
    EXPECT_EQ(spot.colors[634], (Rgba8{133, 74, 42, 255}));
}

TEST(TexturedModels, KipAndTheMilkTruckBringTheirImages) {
    MVW_SKIP_WITHOUT_MODELS();
    for (const std::string name : {"kip/kip.obj", "milktruck.glb"}) {
        CleanReport report;
        const Mesh mesh = read_mesh(models_folder() + "/" + name, report).value();
        EXPECT_EQ(report.textured_vertices, mesh.positions.size()) << name;
        EXPECT_TRUE(report.missing_textures.empty()) << name;
        std::vector<std::uint8_t> greens(256, 0);
        for (const Rgba8& c : mesh.colors) greens[c.g] = 1;
        EXPECT_GT(std::count(greens.begin(), greens.end(), 1), 10) << name;
    }
}

}  // namespace
}  // namespace mvw
