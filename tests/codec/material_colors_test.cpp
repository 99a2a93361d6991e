// Colours of materials: sharp on every level, in wavelets, facets and closing parts, from file to mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "client/drawable.h"
#include "codec/dec_base.h"
#include "codec/decoder.h"
#include "codec/encoder.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "tests/support/encoded_models.h"
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

/// Every face has its material's colour at all three corners.
void expect_sharp(const Mesh& mesh) {
    ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
    ASSERT_EQ(mesh.materials.size(), mesh.faces.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        for (const std::uint32_t v : mesh.faces[f]) ASSERT_EQ(mesh.colors[v], mesh.materials[f] == 3 ? kRed : kBlue);
    EXPECT_EQ(std::set<std::uint32_t>(mesh.materials.begin(), mesh.materials.end()).size(), 2u);
}

TEST(MaterialColors, AreSharpOnEveryLevelAndTheSurfaceStaysClosed) {
    const Mesh input = two_halves(rough_torus(61, 33, 0.01));
    const Bytes file = encoded(input);
    for (unsigned level = 0; level < 6; ++level) {
        const Mesh mesh = decode(file, level).value();
        expect_sharp(mesh);
        // Copies lie where what they copy does: welded, there is no boundary.
        CleanReport report;
        std::vector<std::uint32_t> component_of_face;
        const std::vector<Component> parts = components(clean(mesh, report), component_of_face);
        ASSERT_EQ(parts.size(), 1u);
        EXPECT_EQ(parts[0].boundary_loops, 0u) << level;
        EXPECT_EQ(parts[0].genus, 1) << level;
    }
}

TEST(MaterialColors, ClosingPartsHaveThemToo) {
    const Mesh input = two_halves(rough_torus(41, 23, 0.01));
    EncodeOptions options;
    options.threads = 2;
    const Encoded coded = encode(input, options).value();
    ASSERT_GT(coded.closing_bytes, 0u);
    EXPECT_EQ(coded.material_colors, 2u);
    // At every beginning of it: there is no time when colours are not there.
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_header(coded.file).ok());
    for (const ChunkEntry& c : toc_of(coded.file).chunks) {
        ASSERT_TRUE(decoder.feed_chunk(c.id, payload_of(coded.file, c), c.crc32c).ok());
        expect_sharp(decoder.mesh().value());
    }
    EXPECT_EQ(decoder.mesh().value().faces.size(), input.faces.size());
}

TEST(MaterialColors, FacetsAndLooseFacesHaveThem) {
    Mesh mesh = two_halves(moved(unit_cube(), {-0.5, 0, 0}));
    for (const bool loose : {false, true}) {
        if (loose) mesh.faces.resize(5), mesh.materials.resize(5);
        for (const unsigned level : {0u, 1u}) {
            const Mesh decoded = decode(encoded(mesh, 0), level).value();
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
    const Mesh red = decode(encoded(mesh)).value();
    EXPECT_TRUE(red.materials.empty());
    EXPECT_EQ(red.colors, std::vector<Rgba8>(red.positions.size(), kRed));
    mesh = two_halves(torus(67, 31));
    mesh.material_colors = {{8, kBlue}};
    const Mesh half = decode(encoded(mesh)).value();
    for (std::size_t f = 0; f < half.faces.size(); ++f)
        for (const std::uint32_t v : half.faces[f])
            ASSERT_EQ(half.colors[v], half.materials[f] == 3 ? (Rgba8{255, 255, 255, 255}) : kBlue);
}

TEST(MaterialColors, FieldsOfCopiesAreThoseOfWhatTheyCopy) {
    Mesh mesh = two_halves(torus(67, 31));
    VertexField height{FieldKind::Scalar, "x", {}};
    for (const Vec3& p : mesh.positions) height.values.push_back(p.x);
    mesh.fields.push_back(height);
    const Mesh decoded = decode(encoded(mesh)).value();
    expect_sharp(decoded);
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

}  // namespace
}  // namespace mvw
