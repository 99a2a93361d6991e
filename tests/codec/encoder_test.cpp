#include "codec/encoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "codec/container/crc32c.h"
#include "codec/decoder.h"
#include "codec/enc_base.h"
#include "codec/entropy/packed_planes.h"
#include "codec/measure/surface_error.h"
#include "codec/part_units.h"
#include "codec/tiles.h"
#include "tests/support/encoded_models.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

double decibels(double error) {
    return -20 * std::log10(error);
}

TEST(EncodeParts, ReachesTheErrorItReports) {
    const Encoded& e = small_file();
    const Mesh finest = plain(bumpy_ball(3));
    const double rms = surface_error(finest, decode(e.file).value(), {50'000, 1}).rms;
    EXPECT_NEAR(decibels(e.rms), decibels(rms), 0.2);
    EXPECT_LT(rms, 5.2e-4);
    EXPECT_GT(rms, 1.5e-4) << "far finer than asked for: bytes wasted";
    EXPECT_EQ(e.vertices, finest.positions.size());
}

TEST(EncodeParts, StatesErrorsThatAreTrueAtEveryChunk) {
    const Bytes& file = small_file().file;
    const Mesh finest = plain(bumpy_ball(3));
    for (const ChunkEntry& c : toc_of(file).chunks) {
        const Mesh mesh = decode(ByteSpan(file).first(c.offset + c.length)).value();
        EXPECT_NEAR(decibels(surface_error(finest, mesh, {20'000, 1}).rms), decibels(c.error), 1.0)
            << "at byte " << c.offset + c.length;
    }
}

TEST(EncodeParts, IsDeterministicWhateverTheThreads) {
    EncodeOptions options;
    options.target_error = 1e-3;
    options.threads = 1;
    const Bytes one = encode_parts({bumpy_ball(4)}, options).file;
    options.threads = 3;
    EXPECT_EQ(encode_parts({bumpy_ball(4)}, options).file, one);
}

TEST(Encode, IsDeterministicWhateverTheThreads) {
    // Not semi-regular, so that it is remeshed, bases are compared, and their grids, side by side.
    const Mesh mesh = torus(61, 37);
    EncodeOptions options;
    options.threads = 1;
    const Encoded one = encode(mesh, options).value();
    ASSERT_GT(one.levels, 0u);
    for (const unsigned threads : {2u, 3u}) {
        options.threads = threads;
        EXPECT_EQ(encode(mesh, options)->file, one.file) << threads << " threads";
    }
}

TEST(Encode, DetailsInModelAxesAreLeftWhereTheRemeshHasThem) {
    EncodeOptions options;
    options.threads = 1;
    options.transform.local_frames = false;
    const Mesh mesh = torus(61, 37);
    const Encoded encoded = encode(mesh, options).value();
    EXPECT_GT(encoded.psnr, 60);
}

TEST(EncodeParts, EveryTransformRoundTrips) {
    for (unsigned kind = 0; kind < kTransformCount; ++kind) {
        EncodeOptions options;
        options.transform.kind = TransformKind{static_cast<std::uint8_t>(kind)};
        options.target_error = 1e-3;
        const Encoded e = encode_parts({bumpy_ball(4)}, options);
        EXPECT_LT(e.rms, 1e-3) << transform_name(options.transform.kind);
        EXPECT_EQ(toc_of(e.file).header.transform, kind);
    }
}

TEST(EncodeParts, TheFastProfileGivesTheSameMeshAtEveryChunk) {
    EncodeOptions options;
    options.target_error = 1e-3;
    options.tile_count = 3;
    const Encoded small = encode_parts({bumpy_ball(4)}, options);
    options.profile = Profile::Fast;
    const Encoded fast = encode_parts({bumpy_ball(4)}, options);
    EXPECT_EQ(decode(fast.file)->positions, decode(small.file)->positions);
    EXPECT_GT(fast.file.size(), small.file.size());
    double before = 1;
    for (const ChunkEntry& c : toc_of(fast.file).chunks) {
        const Mesh mesh = decode(ByteSpan(fast.file).first(c.offset + c.length)).value();
        const double rms = surface_error(plain(bumpy_ball(4)), mesh, {20'000, 1}).rms;
        EXPECT_LT(rms, before * 1.006);
        before = std::min(rms, before);
    }
}

TEST(EncodeParts, DamagedPackedPlanesAreSkipped) {
    EncodeOptions options;
    options.profile = Profile::Fast;
    options.target_error = 1e-3;
    const Bytes file = encode_parts({bumpy_ball(3)}, options).file;
    const Toc toc = toc_of(file);
    const ChunkEntry& base = toc.chunks[0];
    for (const ChunkEntry& c : toc.chunks) {
        if (c.id.channel == Channel::Base) continue;
        Bytes payload(payload_of(file, c).begin(), payload_of(file, c).end());
        for (std::size_t at = 2; at < payload.size(); at += 9) {
            Bytes damaged = payload;
            damaged[at] ^= std::byte{0x55};
            Decoder decoder;
            ASSERT_TRUE(decoder.feed_header(file).ok());
            ASSERT_TRUE(decoder.feed_chunk(base.id, payload_of(file, base), base.crc32c).ok());
            (void)decoder.feed_chunk(c.id, damaged, crc32c(damaged)).ok();
            EXPECT_TRUE(decoder.mesh().ok());
            EXPECT_EQ(decoder.state().waiting, 0u);
        }
    }
}

TEST(EncodeParts, PackedPlanesTakenTogetherEqualThoseTakenOneAtATime) {
    EncodeOptions options;
    options.profile = Profile::Fast;
    options.target_error = 1e-7;  // many planes
    options.tile_count = 4;
    const Bytes file = encode_parts({bumpy_ball(4)}, options).file;
    const Toc toc = toc_of(file);
    const auto feed = [&](Decoder& decoder, const ChunkEntry& c) {
        EXPECT_TRUE(decoder.feed_chunk(c.id, payload_of(file, c), c.crc32c).ok());
    };
    Decoder one_at_a_time;
    ASSERT_TRUE(one_at_a_time.feed_header(file).ok());
    for (const ChunkEntry& c : toc.chunks) {
        feed(one_at_a_time, c);
        if (c.id.channel == Channel::Base) continue;
        ASSERT_TRUE(one_at_a_time.mesh().ok());
    }
    for (const unsigned threads : {1u, 3u}) {
        Decoder together({}, threads);
        ASSERT_TRUE(together.feed_header(file).ok());
        for (const ChunkEntry& c : toc.chunks) feed(together, c);
        EXPECT_EQ(together.mesh()->positions, one_at_a_time.mesh()->positions) << threads;
        EXPECT_EQ(together.coefficient_digest(), one_at_a_time.coefficient_digest()) << threads;
    }
}

TEST(EncodeParts, AChunkOfPackedPlanesHoldsTwoWhereItsBlockHas) {
    EncodeOptions options;
    options.profile = Profile::Fast;
    options.target_error = 1e-7;
    options.tile_count = 4;
    const Bytes file = encode_parts({bumpy_ball(5)}, options).file;
    const Toc toc = toc_of(file);
    for (const ChunkEntry& c : toc.chunks) {
        if (c.id.channel != Channel::Geometry) continue;
        ByteReader in(payload_of(file, c));
        const GeometryFront front = read_geometry_front(in);
        const unsigned low = toc.header.layers - 1u - c.id.layer;
        EXPECT_TRUE(front.top_plane > low || (front.starts && low == 0)) << c.offset;
    }
}

/// The planes of a chunk of the fast profile, of so many coefficients, as chunks of one plane each.
std::vector<std::pair<ChunkId, Bytes>> plane_by_plane(const ChunkId& id, ByteSpan payload, unsigned layers,
                                                      std::size_t coefficients) {
    ByteReader in(payload);
    const GeometryFront front = read_geometry_front(in);
    const unsigned low = layers - 1u - id.layer;
    Bytes raw;
    EXPECT_TRUE(unzip_planes(in.bytes(in.remaining()), 3 * coefficients, front.top_plane, low, raw));
    std::vector<std::uint32_t> by_component(3 * coefficients);
    unpack_planes(raw, front.top_plane, low, by_component);
    Entries entries(3 * coefficients);
    for (std::size_t i = 0; i < coefficients; ++i)
        for (std::size_t c = 0; c < 3; ++c) entries[3 * i + c] = by_component[c * coefficients + i];
    std::vector<std::pair<ChunkId, Bytes>> chunks;
    for (unsigned plane = front.top_plane + 1u; plane-- > low;) {
        GeometryFront one = front;
        one.top_plane = plane;
        one.starts = front.starts && plane == front.top_plane;
        ByteWriter out;
        write_geometry_front(out, one);
        out.bytes(pack_planes(entries, 3, plane, plane));
        ChunkId of_plane = id;
        of_plane.layer = static_cast<std::uint8_t>(layers - 1u - plane);
        chunks.emplace_back(of_plane, out.take());
    }
    return chunks;
}

TEST(EncodeParts, PackedPlanesMayComeOneByOne) {
    EncodeOptions options;
    options.profile = Profile::Fast;
    options.target_error = 1e-7;
    const Bytes file = encode_parts({bumpy_ball(4)}, options).file;
    const Toc toc = toc_of(file);
    ASSERT_EQ(toc.header.parts[0].tiles, 1u);
    for (const unsigned threads : {1u, 2u}) {
        Decoder whole, split({}, threads);
        ASSERT_TRUE(whole.feed_header(file).ok());
        ASSERT_TRUE(split.feed_header(file).ok());
        std::size_t split_chunks = 0;
        for (const ChunkEntry& c : toc.chunks) {
            const ByteSpan payload = payload_of(file, c);
            ASSERT_TRUE(whole.feed_chunk(c.id, payload, c.crc32c).ok());
            if (c.id.channel == Channel::Base) {
                ASSERT_TRUE(split.feed_chunk(c.id, payload, c.crc32c).ok());
                continue;
            }
            const BaseMesh& base = *whole.base(0);
            const std::uint64_t coefficients =
                vertices_at_level(base, c.id.level) - (c.id.level > 0 ? vertices_at_level(base, c.id.level - 1u) : 0);
            for (const auto& [id, bytes_of_one] : plane_by_plane(c.id, payload, toc.header.layers, coefficients)) {
                ASSERT_TRUE(split.feed_chunk(id, bytes_of_one, crc32c(bytes_of_one)).ok());
                ++split_chunks;
            }
        }
        EXPECT_GT(split_chunks, toc.chunks.size());
        EXPECT_EQ(split.state().waiting, 0u);
        EXPECT_EQ(split.coefficient_digest(), whole.coefficient_digest());
        EXPECT_EQ(split.mesh()->positions, whole.mesh()->positions);
    }
}

TEST(EncodeParts, ADamagedChunkOfPackedPlanesLeavesRoomForTheGoodOne) {
    EncodeOptions options;
    options.profile = Profile::Fast;
    options.target_error = 1e-3;
    const Bytes file = encode_parts({bumpy_ball(3)}, options).file;
    const Toc toc = toc_of(file);
    Decoder good, hit;
    ASSERT_TRUE(good.feed_header(file).ok());
    ASSERT_TRUE(hit.feed_header(file).ok());
    for (const ChunkEntry& c : toc.chunks) {
        const ByteSpan payload = payload_of(file, c);
        if (c.id.channel != Channel::Base)
            for (const std::size_t length : {payload.size() / 2, payload.size() - 1}) {
                const ByteSpan cut = payload.first(length);
                EXPECT_FALSE(hit.feed_chunk(c.id, cut, crc32c(cut)).ok() && hit.state().damaged == 0);
            }
        ASSERT_TRUE(good.feed_chunk(c.id, payload, c.crc32c).ok());
        ASSERT_TRUE(hit.feed_chunk(c.id, payload, c.crc32c).ok());
    }
    EXPECT_GT(hit.state().damaged, 0u);
    EXPECT_EQ(hit.coefficient_digest(), good.coefficient_digest());
}

TEST(EncodeParts, TransformParametersTravelWithTheFile) {
    EncodeOptions options;
    options.transform = {TransformKind::Interp, 1.0, true, 4, false};
    options.target_error = 1e-3;
    EXPECT_LT(encode_parts({bumpy_ball(4)}, options).rms, 1e-3);
}

TEST(EncodeParts, ManyTilesRoundTripAndDecodeAlone) {
    EncodeOptions options;
    options.target_error = 1e-3;
    options.tile_count = 8;
    const Encoded e = encode_parts({bumpy_ball(4)}, options);
    EXPECT_LT(e.rms, 1e-3);
    EXPECT_EQ(toc_of(e.file).header.parts[0].tiles, 8);
    Decoder some;
    ASSERT_TRUE(some.feed_header(e.file).ok());
    for (const ChunkEntry& c : toc_of(e.file).chunks)
        if (c.id.tile == 0 || c.id.tile == 3) {
            ASSERT_TRUE(some.feed_chunk(c.id, payload_of(e.file, c), c.crc32c).ok());
        }
    EXPECT_EQ(some.mesh()->faces.size(), 8u << 8) << "the other tiles stay coarse, nothing is missing";
}

TEST(EncodeParts, PartsOfEveryKindShareAFile) {
    SemiRegularMesh alone = bumpy_ball(0), far = bumpy_ball(2);
    for (Vec3& p : alone.positions) p += Vec3{3, 0, 0};
    for (Vec3& p : far.positions) p += Vec3{0, 3, 0};
    alone.materials.assign(8, 5);
    far.materials = {1, 1, 2, 2, 1, 1, 2, 9};
    far.creases.assign(far.base.edge_count(), 0);
    for (std::size_t e = 0; e < far.creases.size(); e += 3) far.creases[e] = 1;
    EncodeOptions options;
    options.target_error = 1e-3;
    const Encoded e = encode_parts({bumpy_ball(3), far, alone}, options);
    EXPECT_LT(e.rms, 1e-3);
    const Mesh mesh = decode(e.file).value();
    ASSERT_EQ(mesh.materials.size(), mesh.faces.size());
    EXPECT_EQ(std::count(mesh.materials.begin(), mesh.materials.end(), 5u), 8);
    EXPECT_EQ(std::count(mesh.materials.begin(), mesh.materials.end(), 2u), 3 * 16);
    EXPECT_EQ(std::count(mesh.materials.begin(), mesh.materials.end(), 9u), 16);
}

TEST(EncodeParts, WhatIsNotPayloadIsAFewPerCent) {
    EncodeOptions options;
    options.target_error = 2e-5;
    const Bytes file = encode_parts({bumpy_ball(5)}, options).file;
    const Toc toc = toc_of(file);
    std::uint64_t payload = 0, short_ones = 0;
    for (const ChunkEntry& c : toc.chunks) {
        payload += c.length;
        if (c.id.channel == Channel::Geometry && c.length < 150) ++short_ones;
        const std::uint64_t prefix = c.offset + c.length;
        if (prefix >= 500) {
            EXPECT_LT(static_cast<double>(prefix - payload), 0.15 * static_cast<double>(prefix)) << prefix;
        }
        if (prefix >= 2500) {
            EXPECT_LT(static_cast<double>(prefix - payload), 0.05 * static_cast<double>(prefix)) << prefix;
        }
    }
    EXPECT_LT(static_cast<double>(file.size() - payload), 0.05 * static_cast<double>(file.size()));
    EXPECT_GE(short_ones, 3u) << "early in the file, so that it has many qualities there, too";
}

std::array<std::int32_t, 3> on_grid(const Vec3& p, unsigned bits) {
    std::array<std::int32_t, 3> g{};
    for (std::size_t k = 0; k < 3; ++k) g[k] = static_cast<std::int32_t>(std::lround(std::ldexp(p[k], int(bits))));
    return g;
}

TEST(CodedBase, KeepsTheSurfaceWhateverOrderDracoChose) {
    for (const unsigned bits : {1u, 3u, 10u}) {
        const SemiRegularMesh ball = bumpy_ball(2);
        std::vector<Vec3> points(ball.positions.begin(), ball.positions.begin() + ball.base.vertex_count());
        for (Vec3& p : points) p *= 0.3;  // at 1 bit many of them coincide
        PartUnits::Grid grid;
        for (const Vec3& p : points) grid.push_back(on_grid(p, bits));
        for (const bool alone : {true, false}) {
            const CodedBase base = code_base(ball.base, grid, bits, alone);
            EXPECT_EQ(base.method == BaseMethod::Grown, !alone) << bits << " bits";
            const SemiRegularMesh moved = renumber(ball, base);
            for (std::uint32_t v = 0; v < moved.base.vertex_count(); ++v)
                for (std::size_t k = 0; k < 3; ++k)
                    EXPECT_NEAR(std::ldexp(base.grid[v][k], -int(bits)), 0.3 * moved.positions[v][k],
                                std::ldexp(0.51, -int(bits)));
            const auto order = [](const Vec3& a, const Vec3& b) {
                return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
            };
            std::vector<Vec3> before = ball.positions, after = moved.positions;
            std::sort(before.begin(), before.end(), order);
            std::sort(after.begin(), after.end(), order);
            EXPECT_EQ(before, after);
            EXPECT_LT(surface_error(plain(ball), plain(moved), {2000, 1}).max, 1e-12);
        }
    }
}

TEST(CodedBase, CoincidentVerticesAndManyEqualPartsKeepTheirConnections) {
    // Forty tetrahedra within one cell of the grid: only their connections tell them apart.
    std::vector<Face> faces;
    PartUnits::Grid grid;
    for (std::uint32_t i = 0; i < 40; ++i) {
        const std::uint32_t a = 4 * i;
        for (const Face& f :
             {Face{a, a + 2, a + 1}, Face{a, a + 1, a + 3}, Face{a + 1, a + 2, a + 3}, Face{a + 2, a, a + 3}})
            faces.push_back(f);
        for (int k = 0; k < 4; ++k) grid.push_back(on_grid({1e-4 * i, 1e-4 * k, 0}, 6));
    }
    const BaseMesh base = BaseMesh::create(160, faces).value();
    for (const bool alone : {true, false}) {
        const CodedBase coded = code_base(base, grid, 6, alone);
        EXPECT_EQ(coded.mesh.face_count(), 160u);
        EXPECT_EQ(std::set<std::uint32_t>(coded.source_face.begin(), coded.source_face.end()).size(), 160u);
    }
}

/// From level 1 on two edges would join the same vertices: a hostile file's base, which transforms could not name.
TEST(CodedBase, TwoFacesOnEachOtherAreRefusedWithMoreThanOneLevel) {
    for (const bool alone : {true, false}) {
        SemiRegularMesh mesh;
        mesh.base = BaseMesh::create(3, {{0, 1, 2}, {0, 2, 1}}).value();
        mesh.positions = {{0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0}};
        const CodedBase coded = code_base(mesh.base, {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}}, 4, alone);
        for (std::uint8_t levels = 0; levels <= 3; ++levels) {
            PartParams params;
            params.lattice.bits = 4;
            if (levels > 0) params.steps.assign(levels + 1u, 9), params.across.assign(levels + 1u, 9);
            SemiRegularMesh coded_mesh = renumber(mesh, coded);
            coded_mesh.levels = levels;
            const Bytes payload = write_base(coded, coded_mesh, params);
            const Result<DecodedBase> base = read_base(payload, {levels, 3, 3, 2}, 0);
            ASSERT_EQ(base.ok(), levels <= 1) << unsigned{levels};
            if (!base.ok()) {
                EXPECT_EQ(base.error().message, "two faces of the base lie on each other");
            }
        }
    }
}

TEST(Tiles, AreConnectedAndBalanced) {
    Mesh grid = grid_mesh(30);
    const BaseMesh base = BaseMesh::create(static_cast<std::uint32_t>(grid.positions.size()), grid.faces).value();
    for (const unsigned tiles : {1u, 2u, 7u, 64u, 1800u}) {
        const std::vector<std::uint16_t> tile = tile_of_faces(base, tiles);
        std::vector<std::uint32_t> size(tiles, 0);
        for (const std::uint16_t t : tile) ++size.at(t);
        EXPECT_GE(*std::min_element(size.begin(), size.end()), 1u);
        EXPECT_LE(*std::max_element(size.begin(), size.end()), 3 * 1800 / tiles + 1) << tiles;
        // Within each tile, faces that meet at an edge form one group.
        std::vector<std::uint32_t> group(tile.size());
        for (std::uint32_t f = 0; f < group.size(); ++f) group[f] = f;
        const auto root = [&](std::uint32_t f) {
            while (group[f] != f) f = group[f] = group[group[f]];
            return f;
        };
        for (const BaseEdge& e : base.edges())
            if (e.face[1] != kNone && tile[e.face[0]] == tile[e.face[1]]) group[root(e.face[0])] = root(e.face[1]);
        std::set<std::uint32_t> groups;
        for (std::uint32_t f = 0; f < group.size(); ++f) groups.insert(root(f));
        EXPECT_EQ(groups.size(), tiles);
    }
}

TEST(Encode, RefusesWhatHasNoSurface) {
    Mesh flat;
    flat.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    flat.faces = {{0, 1, 2}};
    EXPECT_FALSE(encode({}, {}).ok());
    EXPECT_FALSE(encode(flat, {}).ok());
}

TEST(Encode, TheSmallestMeshesRoundTrip) {
    for (const Mesh& mesh : {tetrahedron_mesh(), grid_mesh(1), moebius_mesh(7)}) {
        const Result<Encoded> e = encode(mesh, {});
        ASSERT_TRUE(e.ok()) << e.error().message;
        EXPECT_LT(surface_error(mesh, decode(e->file).value(), {2000, 1}).rms, 1e-3)
            << mesh.faces.size() << " faces: levels " << e->levels << ", base " << e->base_faces << ", alone "
            << e->draco_area_share;
    }
}

TEST(Encode, ARealModelStatesTrueErrorsAndNeverGetsWorse) {
    MVW_SKIP_WITHOUT_MODELS();
    const Mesh spot = clean_model("spot/spot_triangulated.obj");
    const Encoded e = encode(spot, {}).value();
    EXPECT_EQ(e.draco_area_share, 0);
    const Toc toc = toc_of(e.file);
    double best = 0;
    for (const ChunkEntry& c : toc.chunks) {
        const Mesh mesh = decode(ByteSpan(e.file).first(c.offset + c.length)).value();
        const double psnr = surface_error(spot, mesh, {300'000, 0}).psnr;  // as the encoder mixes samples and vertices
        EXPECT_NEAR(psnr, decibels(c.error), 1.0) << "at byte " << c.offset + c.length;
        EXPECT_GT(psnr, best - 0.05) << "at byte " << c.offset + c.length;
        best = std::max(best, psnr);
    }
}

TEST(Encode, ModelsWithSharpEdgesGoWithoutLiftingWhereThatIsNoWorse) {
    MVW_SKIP_WITHOUT_MODELS();
    const Mesh fandisk = clean_model("fandisk.off");
    EncodeOptions options;
    const Encoded chosen = encode(fandisk, options).value();
    EXPECT_EQ(chosen.transform, TransformKind::SeededNormalLazy);
    options.choose_transform = false;
    const Encoded lifted = encode(fandisk, options).value();
    EXPECT_EQ(lifted.transform, TransformKind::SeededNormal);
    const auto psnr_at = [&](const Encoded& encoded, std::size_t bytes) {
        Decoder decoder;
        EXPECT_TRUE(decoder.feed(ByteSpan(encoded.file).first(bytes)).ok());
        return surface_error(fandisk, decoder.mesh().value(), {50'000, 0}).psnr;
    };
    EXPECT_GT(psnr_at(chosen, 4096), psnr_at(lifted, 4096) + 3);
}

}  // namespace
}  // namespace mvw
