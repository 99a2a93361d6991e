// Colours of materials: sharp on every level, in wavelets, facets, closing and progressive parts, from file to mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "client/drawable.h"
#include "codec/dec_base.h"
#include "codec/decoder.h"
#include "codec/encoder.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/material_colors.h"
#include "tests/support/encoded_models.h"
#include "tests/support/meshes.h"
#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

constexpr Rgba8 kRed{200, 30, 20, 255}, kBlue{10, 40, 220, 128};

/// Red where x is below 0, blue above; each face is one of them.
Mesh two_halves(Mesh mesh) {
    for (const Face& f : mesh.faces) {
        const double x = mesh.positions[f[0]].x + mesh.positions[f[1]].x + mesh.positions[f[2]].x;
        mesh.materials.push_back(x < 0 ? 3 : 8);
    }
    mesh.material_colors = {{3, kRed}, {8, kBlue}};
    return mesh;
}

/// By a base of so many faces; 0: chosen.
Bytes encoded(const Mesh& mesh, unsigned base_faces = 150) {
    EncodeOptions options;
    options.base_faces = base_faces;
    options.threads = 2;
    return encode(mesh, options).value().file;
}

/// Every face has its material's colour at all three corners, once vertices have them.
void expect_sharp(Mesh mesh) {
    const std::size_t vertices = mesh.positions.size();
    const std::vector<std::uint32_t> copied = colors_to_vertices(mesh);
    ASSERT_EQ(mesh.positions.size(), vertices + copied.size());
    for (std::size_t k = 0; k < copied.size(); ++k) EXPECT_EQ(mesh.positions[vertices + k], mesh.positions[copied[k]]);
    ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
    ASSERT_EQ(mesh.materials.size(), mesh.faces.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        for (const std::uint32_t v : mesh.faces[f]) ASSERT_EQ(mesh.colors[v], mesh.materials[f] == 3 ? kRed : kBlue);
    EXPECT_EQ(std::set<std::uint32_t>(mesh.materials.begin(), mesh.materials.end()).size(), 2u);
}

TEST(MaterialColors, OneColorOfAllVerticesIsOneOfTheFaces) {
    Mesh ball = icosphere(3);
    constexpr Rgba8 kGreen{10, 190, 40, 255};
    ball.colors.assign(ball.positions.size(), kGreen);
    const Encoded encoded = encode(ball, {}).value();
    EXPECT_TRUE(encoded.attributes.empty());
    EXPECT_EQ(encoded.material_colors, 1u);
    Mesh back = decode(encoded.file).value();
    EXPECT_TRUE(back.colors.empty());
    EXPECT_TRUE(colors_to_vertices(back).empty());
    EXPECT_EQ(back.colors, std::vector<Rgba8>(back.positions.size(), kGreen));

    ball.colors[7] = kRed;
    EXPECT_EQ(encode(ball, {})->attributes.size(), 1u);
    ball.colors[7] = kGreen;
    ball.materials.assign(ball.faces.size(), 4);
    EXPECT_EQ(encode(ball, {})->attributes.size(), 1u) << "faces of materials stay with them";
    ball.materials.clear();
    ball.colors.assign(ball.positions.size(), kBlue);
    EXPECT_EQ(encode(ball, {})->attributes.size(), 1u) << "a material's alpha would be seen";
}

TEST(MaterialColors, AreSharpOnEveryLevelAndTheSurfaceStaysClosed) {
    const Mesh input = two_halves(rough_torus(61, 33, 0.01));
    const Bytes file = encoded(input);
    for (unsigned level = 0; level < 6; ++level) {
        const Mesh mesh = decode(file, level).value();
        expect_sharp(mesh);
        std::vector<std::uint32_t> component_of_face;
        const std::vector<Component> parts = components(mesh, component_of_face);
        ASSERT_EQ(parts.size(), 1u);
        EXPECT_EQ(parts[0].boundary_loops, 0u) << level;
        EXPECT_EQ(parts[0].genus, 1) << level;
    }
}

TEST(MaterialColors, ClosingAndProgressivePartsHaveThemToo) {
    for (const bool progressive : {false, true}) {
        const Mesh input = two_halves(rough_torus(41, 23, progressive ? 0.01 : 0.003));
        EncodeOptions options;
        options.threads = 2;
        options.choose_transform = progressive;  // given ones are used, not plain triangles alone
        const Encoded coded = encode(input, options).value();
        const Toc toc = toc_of(coded.file);
        ASSERT_TRUE(progressive ? toc.header.parts[0].progressive : toc.header.parts.back().supersedes);
        EXPECT_EQ(coded.material_colors, 2u);
        // At every beginning of it: there is no time when colours are not there.
        Decoder decoder;
        ASSERT_TRUE(decoder.feed_header(coded.file).ok());
        for (const ChunkEntry& c : toc.chunks) {
            ASSERT_TRUE(decoder.feed_chunk(c.id, payload_of(coded.file, c), c.crc32c).ok());
            expect_sharp(decoder.mesh().value());
        }
        EXPECT_EQ(decoder.mesh().value().faces.size(), input.faces.size());
    }
}

TEST(MaterialColors, FacetsAndLooseFacesHaveThem) {
    Mesh mesh = two_halves(moved(unit_cube(), {-0.5, 0, 0}));
    for (const bool loose : {false, true}) {
        if (loose) mesh.faces.resize(5), mesh.materials.resize(5);
        for (const unsigned level : {0u, 1u}) {
            Mesh decoded = decode(encoded(mesh, 0), level).value();
            (void)colors_to_vertices(decoded);
            ASSERT_EQ(decoded.colors.size(), decoded.positions.size());
            for (std::size_t f = 0; f < decoded.faces.size(); ++f)
                for (const std::uint32_t v : decoded.faces[f])
                    EXPECT_EQ(decoded.colors[v], decoded.materials[f] == 3 ? kRed : kBlue);
        }
    }
}

TEST(MaterialColors, OneMaterialNeedsNoLabelsAndUnknownOnesAreWhite) {
    Mesh mesh = torus(67, 31);
    mesh.material_colors = {{0, kRed}};
    Mesh red = decode(encoded(mesh)).value();
    (void)colors_to_vertices(red);
    EXPECT_TRUE(red.materials.empty());
    EXPECT_EQ(red.colors, std::vector<Rgba8>(red.positions.size(), kRed));
    mesh = two_halves(torus(67, 31));
    mesh.material_colors = {{8, kBlue}};
    Mesh half = decode(encoded(mesh)).value();
    (void)colors_to_vertices(half);
    for (std::size_t f = 0; f < half.faces.size(); ++f)
        for (const std::uint32_t v : half.faces[f])
            ASSERT_EQ(half.colors[v], half.materials[f] == 3 ? (Rgba8{255, 255, 255, 255}) : kBlue);
}

TEST(MaterialColors, FieldsOfCopiesAreThoseOfWhatTheyCopy) {
    Mesh mesh = two_halves(torus(67, 31));
    VertexField height{FieldKind::Scalar, "x", {}};
    for (const Vec3& p : mesh.positions) height.values.push_back(p.x);
    mesh.fields.push_back(height);
    Mesh decoded = decode(encoded(mesh)).value();
    expect_sharp(decoded);
    ASSERT_FALSE(colors_to_vertices(decoded).empty());
    ASSERT_EQ(decoded.fields.size(), 1u);
    ASSERT_EQ(decoded.fields[0].values.size(), decoded.positions.size());
    for (std::size_t v = 0; v < decoded.positions.size(); ++v)
        EXPECT_NEAR(decoded.fields[0].values[v], decoded.positions[v].x, 0.05);
}

TEST(MaterialColors, WireframesHaveAllEdges) {
    const Bytes file = encoded(two_halves(torus(67, 31)));
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_file(file));
    client::DrawableOptions options;
    options.level = 1;
    options.edges = true;
    const client::Drawable d = client::make_drawable(decoder, options).value();
    const auto key = [&](std::uint32_t a, std::uint32_t b) {
        const auto place = [&](std::uint32_t v) {
            return std::array{d.positions[v].x, d.positions[v].y, d.positions[v].z};
        };
        return std::minmax(place(a), place(b));
    };
    std::set<std::pair<std::array<float, 3>, std::array<float, 3>>> drawn, wanted;
    for (std::size_t e = 0; e < d.edges.size(); e += 2) drawn.insert(key(d.edges[e], d.edges[e + 1]));
    for (std::size_t t = 0; t < d.triangles.size(); t += 3)
        for (std::size_t k = 0; k < 3; ++k) wanted.insert(key(d.triangles[t + k], d.triangles[t + (k + 1) % 3]));
    EXPECT_EQ(drawn, wanted);
}

TEST(MaterialColors, DamagedOnesAreRefused) {
    Mesh mesh = two_halves(torus(67, 31));
    const Bytes file = encoded(mesh);
    const Toc toc = toc_of(file);
    const ByteSpan base = payload_of(file, toc.chunks[0]);
    ASSERT_EQ(toc.chunks[0].id.channel, Channel::Base);
    ASSERT_TRUE(read_base(base, toc.header.parts[0], toc.header.transform).ok());
    // The two of them are the last 11 bytes: a count, then each five.
    const auto with = [&](std::size_t from_end, int value) {
        Bytes damaged(base.begin(), base.end());
        damaged[damaged.size() - from_end] = static_cast<std::byte>(value);
        return read_base(damaged, toc.header.parts[0], toc.header.transform);
    };
    EXPECT_EQ(with(11, 0).error().code, Errc::Malformed) << "none";
    EXPECT_EQ(with(11, 3).error().code, Errc::Malformed) << "more than there is";
    EXPECT_EQ(with(5, 0).error().code, Errc::Malformed) << "one label twice";
    EXPECT_EQ(with(10, 9).value().params.colors[1].label, 14u);
}

TEST(MaterialColors, NormalsAreOneWhereColoursMeetAndTheSolidStaysOne) {
    const Bytes file = encoded(two_halves(torus(67, 31)));
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_file(file));
    const client::Drawable d = client::make_drawable(decoder, {}).value();
    EXPECT_TRUE(d.solid);
    const Mesh mesh = decoder.mesh().value();
    Mesh split = mesh;
    const std::vector<std::uint32_t> copied = colors_to_vertices(split);
    ASSERT_FALSE(copied.empty());
    ASSERT_EQ(d.positions.size(), split.positions.size());
    ASSERT_EQ(d.normals.size(), split.positions.size());
    ASSERT_EQ(d.colors, split.colors);
    for (std::size_t k = 0; k < copied.size(); ++k)
        EXPECT_EQ(d.normals[mesh.positions.size() + k], d.normals[copied[k]]);
}

TEST(MaterialColors, FilesOfMeshesKeepThem) {
    const Mesh mesh = decode(encoded(two_halves(torus(67, 31)))).value();
    CleanReport report;
    const auto back = [&](MeshFormat format) {
        return read_mesh_from_memory(write_mesh_to_memory(mesh, format).value(), format, report).value();
    };
    const Mesh glb = back(MeshFormat::Glb);
    ASSERT_EQ(glb.material_colors.size(), 2u);
    EXPECT_EQ(glb.material_colors[0].color, kRed);
    EXPECT_EQ(glb.material_colors[1].color, kBlue);
    EXPECT_TRUE(glb.colors.empty());
    for (const MeshFormat format : {MeshFormat::Ply, MeshFormat::Off}) {
        const Mesh other = back(format);
        ASSERT_EQ(other.colors.size(), other.positions.size());
        for (std::size_t f = 0; f < other.faces.size(); ++f)
            for (const std::uint32_t v : other.faces[f])
                ASSERT_EQ(other.colors[v].r, (mesh.materials[f] == 3 ? kRed : kBlue).r);
    }
    EXPECT_EQ(left_out_by(MeshFormat::Stl, mesh), std::vector<std::string>{"color"});
}

TEST(MaterialColors, CopiesAreAtMostAsManyAsVertices) {
    // A fan whose faces are all of other colours: each rim vertex is in two, the middle in all.
    Mesh fan;
    fan.positions.push_back({0, 0, 1});
    constexpr std::uint32_t kFaces = 40;
    for (std::uint32_t k = 0; k < kFaces; ++k) {
        fan.positions.push_back({std::cos(k * 0.157), std::sin(k * 0.157), 0});
        fan.faces.push_back({0, 1 + k, 1 + (k + 1) % kFaces});
        fan.materials.push_back(k);
        fan.material_colors.push_back({k, {static_cast<std::uint8_t>(k), 0, 0, 255}});
    }
    EXPECT_EQ(colors_to_vertices(fan).size(), kFaces + 1);
    EXPECT_EQ(fan.positions.size(), 2 * (kFaces + 1));
}

TEST(MaterialColors, MustBeInTheOrderOfTheirLabels) {
    Mesh mesh = two_halves(unit_cube());
    std::swap(mesh.material_colors[0], mesh.material_colors[1]);
    EXPECT_EQ(encode(mesh, {}).error().code, Errc::InvalidArgument);
}

TEST(MaterialColors, OpenFacetsOfSeveralMaterialsBesideARemeshedPart) {
    Mesh patch = grid_mesh(5);
    for (Vec3& p : patch.positions) p += Vec3{3, 0, 0};
    const Mesh mesh = two_halves(join(torus(67, 31), patch));
    EncodeOptions options;
    options.threads = 2;
    expect_sharp(decode(encode(mesh, options).value().file).value());
}

}  // namespace
}  // namespace mvw
