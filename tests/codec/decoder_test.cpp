#include "codec/decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "codec/container/crc32c.h"
#include "codec/container/enc_file.h"
#include "codec/dec_part.h"
#include "codec/measure/surface_error.h"
#include "codec/part_params.h"
#include "tests/support/encoded_models.h"
#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

bool same(const Mesh& a, const Mesh& b) {
    return a.positions == b.positions && a.faces == b.faces && a.materials == b.materials;
}

std::size_t end_of_bases(const Toc& toc) {
    std::size_t end = 0;
    for (const ChunkEntry& c : toc.chunks)
        if (c.id.channel == Channel::Base) end = c.offset + c.length;
    return end;
}

TEST(Decoder, ByteAtATimeEqualsOneShot) {
    const Bytes& file = small_file().file;
    Decoder slow;
    for (const std::byte& b : file) ASSERT_TRUE(slow.feed({&b, 1}).ok());
    EXPECT_TRUE(slow.state().complete);
    EXPECT_EQ(slow.state().damaged, 0u);
    EXPECT_EQ(slow.state().chunks, toc_of(file).chunks.size());
    EXPECT_TRUE(same(slow.mesh().value(), decode(file).value()));
}

TEST(Decoder, EveryTruncationGivesTheBestMeshOfItsBytes) {
    const Bytes& file = small_file().file;
    const Toc toc = toc_of(file);
    const Mesh finest = plain(bumpy_ball(3));
    double best = 1;
    for (std::size_t n = 0; n <= file.size(); ++n) {
        const Bytes prefix(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(n));
        const Result<Mesh> mesh = decode(prefix);
        if (n < end_of_bases(toc)) {
            EXPECT_FALSE(mesh.ok()) << n;
            continue;
        }
        ASSERT_TRUE(mesh.ok()) << n << ": " << mesh.error().message;
        if (n % 16 != 0) continue;
        const double rms = surface_error(finest, *mesh, {2000, 1}).rms;
        EXPECT_LT(rms, best * 1.03) << "more bytes made it worse at " << n;  // of few samples
        best = std::min(best, rms);
    }
    EXPECT_LT(best, 6e-4);
}

/// A file of this one's header and chunks, with each first chunk of a level above 0 asking for `least` bytes.
Bytes asking_for(const Bytes& file, std::uint64_t least) {
    const Toc toc = toc_of(file);
    std::vector<Bytes> payloads;
    std::vector<ChunkToWrite> chunks;
    for (const ChunkEntry& c : toc.chunks) {
        const ByteSpan payload = ByteSpan(file).subspan(c.offset, c.length);
        payloads.emplace_back(payload.begin(), payload.end());
        if (c.id.channel != Channel::Geometry || c.id.level == 0) continue;
        ByteReader in(payload);
        GeometryFront front = read_geometry_front(in);
        if (!front.starts) continue;
        front.least_bytes = least;
        payloads.back() = with_front(front, in);
    }
    for (std::size_t i = 0; i < payloads.size(); ++i)
        chunks.push_back({toc.chunks[i].id, payloads[i], toc.chunks[i].error});
    return write_file(toc.header, chunks).value();
}

TEST(Decoder, ACutChunkOfFewerThanItsLeastBytesIsNotShown) {
    constexpr std::uint64_t kLeast = 20;
    const Bytes file = asking_for(small_file().file, kLeast);
    EXPECT_TRUE(same(decode(file).value(), decode(small_file().file).value()));
    unsigned asking = 0, shown = 0;
    for (const ChunkEntry& c : toc_of(file).chunks) {
        if (c.id.channel != Channel::Geometry || c.id.level == 0) continue;
        ByteReader in(ByteSpan(file).subspan(c.offset, c.length));
        if (read_geometry_front(in).least_bytes == 0 || in.remaining() <= kLeast) continue;
        ++asking;
        const std::size_t front = c.length - in.remaining();
        const Mesh none = decode(ByteSpan(file).first(c.offset)).value();
        EXPECT_TRUE(same(none, decode(ByteSpan(file).first(c.offset + front + kLeast - 1)).value()));
        shown += same(none, decode(ByteSpan(file).first(c.offset + front + kLeast)).value()) ? 0 : 1;
    }
    EXPECT_GT(asking, 0u);
    EXPECT_EQ(shown, asking);
}

TEST(Decoder, ABeginningOfAChunkIsWhatACutOneIs) {
    const Bytes& file = small_file().file;
    const Toc toc = toc_of(file);
    std::vector<Bytes> payloads;
    for (const ChunkEntry& c : toc.chunks) {
        const ByteSpan payload = payload_of(file, c);
        payloads.emplace_back(payload.begin(), payload.end());
    }
    unsigned compared = 0, shown = 0;
    for (std::size_t last = 0; last < toc.chunks.size(); ++last) {
        const ChunkEntry& c = toc.chunks[last];
        if (c.id.channel != Channel::Geometry) continue;
        ByteReader in(payloads[last]);
        GeometryFront front = read_geometry_front(in);
        front.beginning = true;
        const std::size_t half = in.remaining() / 2, front_bytes = c.length - in.remaining();
        const Bytes beginning = with_front(front, ByteReader(in.bytes(half)));
        std::vector<ChunkToWrite> chunks;
        for (std::size_t i = 0; i <= last; ++i)
            chunks.push_back({toc.chunks[i].id, i == last ? beginning : payloads[i], toc.chunks[i].error});
        Decoder decoder;
        ASSERT_TRUE(decoder.feed(write_file(toc.header, chunks).value()).ok());
        EXPECT_TRUE(decoder.state().complete) << last;
        const Mesh mesh = decoder.mesh().value();
        EXPECT_TRUE(same(mesh, decode(ByteSpan(file).first(c.offset + front_bytes + half)).value())) << last;
        shown += same(mesh, decode(ByteSpan(file).first(c.offset)).value()) ? 0 : 1;
        ++compared;
    }
    EXPECT_GT(compared, 2u);
    EXPECT_GE(shown + 1, compared);
}

/// A cube of sharp edges in three levels, its faces flat, or with a bump each.
SemiRegularMesh cube(double bump) {
    SemiRegularMesh part;
    const Mesh box = unit_cube();
    part.base = BaseMesh::create(8, box.faces).value();
    part.levels = 3;
    part.creases.assign(part.base.edge_count(), 1);
    part.positions.resize(vertices_at_level(part.base, part.levels));
    std::vector<std::uint32_t> patch;
    for (std::uint32_t f = 0; f < part.base.face_count(); ++f) {
        patch_vertices(part.base, f, part.levels, patch);
        const Face& c = box.faces[f];
        for (std::uint32_t i = 0; i <= 8; ++i)
            for (std::uint32_t k = 0; i + k <= 8; ++k) {
                const double inside = double(i) * k * (8 - i - k) / 18;
                const Vec3 at = box.positions[c[0]] * (8.0 - i - k) + box.positions[c[1]] * i + box.positions[c[2]] * k;
                part.positions[patch[patch_place(8, i, k)]] = at * (1 + bump * inside) * 0.125;
            }
    }
    return part;
}

TEST(Decoder, FacetsAreFlatUntilDetailsComeAndThenAsTheTransformHasThem) {
    for (const double bump : {0.0, 0.1}) {
        const Bytes file = encode_parts({cube(bump)}).file;
        Decoder decoder;
        ASSERT_TRUE(decoder.feed_header(file).ok());
        bool any_details = false;
        for (const ChunkEntry& c : toc_of(file).chunks) {
            ASSERT_TRUE(decoder.feed_chunk(c.id, payload_of(file, c), c.crc32c).ok());
            any_details = any_details || (c.id.channel == Channel::Geometry && c.id.level > 0);
            if (any_details) continue;
            EXPECT_LT(surface_error(unit_cube(), decoder.mesh().value(), {10'000, 1}).max, bump > 0 ? 0.1 : 1e-2);
        }
        EXPECT_EQ(any_details, bump > 0);
        // The transform itself, of all coefficients.
        const Mesh once = decode(file).value(), stepwise = decoder.mesh().value();
        const SemiRegularMesh truth = cube(bump);
        ASSERT_EQ(once.positions.size(), truth.positions.size());
        for (std::size_t v = 0; v < once.positions.size(); ++v)
            EXPECT_LT(length(once.positions[v] - stepwise.positions[v]), 1e-6) << v;
        EXPECT_LT(surface_error(finest_mesh(std::span(&truth, 1)), once, {10'000, 1}).max, 2e-3);
    }
}

TEST(Decoder, ChunksInAnyOrderGiveTheSameMesh) {
    const Bytes& file = small_file().file;
    Toc toc = toc_of(file);
    const Mesh whole = decode(file).value();
    std::mt19937 random(7);
    for (int round = 0; round < 20; ++round) {
        std::shuffle(toc.chunks.begin(), toc.chunks.end(), random);
        Decoder decoder;
        ASSERT_TRUE(decoder.feed_header(file).ok());
        for (const ChunkEntry& c : toc.chunks) {
            ASSERT_TRUE(decoder.feed_chunk(c.id, payload_of(file, c), c.crc32c).ok());
            ASSERT_TRUE(decoder.feed_chunk(c.id, payload_of(file, c), c.crc32c).ok()) << "twice does no harm";
        }
        EXPECT_TRUE(same(decoder.mesh().value(), whole));
    }
}

TEST(Decoder, ADamagedChunkIsSkippedAndTheRestStillDecodes) {
    const Bytes& file = small_file().file;
    const Toc toc = toc_of(file);
    const Mesh finest = plain(bumpy_ball(3));
    for (std::size_t i = toc.header.parts.size(); i < toc.chunks.size(); ++i) {
        Bytes damaged = file;
        damaged[toc.chunks[i].offset + toc.chunks[i].length / 2] ^= std::byte{0x10};
        Decoder stream;
        EXPECT_TRUE(stream.feed(damaged).ok());
        EXPECT_EQ(stream.state().damaged, 1u);
        EXPECT_FALSE(stream.state().complete);
        const double rms = surface_error(finest, stream.mesh().value(), {2000, 1}).rms;
        EXPECT_LT(rms, 0.1);
        EXPECT_TRUE(same(stream.mesh().value(), decode(damaged).value()));
    }
}

TEST(Decoder, NoFlippedByteCrashesItOrGoesUnnoticed) {
    const Bytes& file = small_file().file;
    const std::uint64_t body_end = toc_of(file).header.index_offset;
    for (std::size_t at = 0; at < file.size(); ++at)
        for (const unsigned flip : {0x01u, 0xFFu}) {
            Bytes damaged = file;
            damaged[at] ^= static_cast<std::byte>(flip);
            Decoder decoder;
            const bool fed = decoder.feed(damaged).ok();
            decoder.finish();
            (void)decoder.mesh().ok();
            if (at < body_end) {
                EXPECT_TRUE(!fed || !decoder.state().complete) << "byte " << at;
            }
            (void)decode(damaged).ok();
        }
}

TEST(Decoder, AWrongChecksumIsReportedAndTheChunkCanComeAgain) {
    const Bytes& file = small_file().file;
    const Toc toc = toc_of(file);
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_header(file).ok());
    for (const ChunkEntry& c : toc.chunks) {
        const Result<void> wrong = decoder.feed_chunk(c.id, payload_of(file, c), c.crc32c ^ 1u);
        ASSERT_FALSE(wrong.ok());
        EXPECT_EQ(wrong.error().code, Errc::Malformed);
        ASSERT_TRUE(decoder.feed_chunk(c.id, payload_of(file, c), c.crc32c).ok());
    }
    EXPECT_TRUE(same(decoder.mesh().value(), decode(file).value()));
}

TEST(Decoder, StopsAtTheLevelThatFitsItsLimits) {
    const Bytes& file = small_file().file;
    Limits limits;
    limits.max_vertices = 100;  // level 2 has 66
    EXPECT_EQ(decode(file, 255, limits)->positions.size(), 66u);
    limits = {};
    limits.max_memory_bytes = 192 * 20;
    EXPECT_EQ(decode(file, 255, limits)->positions.size(), 18u);
}

TEST(Decoder, MeshesTakenOnTheWayAreThoseOfAFreshDecoder) {
    EncodeOptions options;
    options.tile_count = 6;
    const Bytes file = encode_parts({bumpy_ball(5)}, options).file;
    const Toc toc = toc_of(file);
    Decoder on_the_way;
    ASSERT_TRUE(on_the_way.feed_header(file).ok());
    bool tiles = false;
    for (const ChunkEntry& c : toc.chunks) {
        ASSERT_TRUE(on_the_way.feed_chunk(c.id, payload_of(file, c), c.crc32c).ok());
        tiles = tiles || c.id.tile > 0;
        // Now and then at another level, and twice with nothing between.
        if (c.id.layer % 4 == 3) {
            EXPECT_TRUE(on_the_way.mesh(3).ok());
        }
        const Mesh mesh = on_the_way.mesh().value();
        EXPECT_TRUE(same(mesh, on_the_way.mesh().value()));
        EXPECT_TRUE(same(mesh, decode(ByteSpan(file).first(c.offset + c.length)).value())) << c.offset;
    }
    EXPECT_TRUE(tiles);
}

TEST(Decoder, MeshDoesNotDependOnThreads) {
    EncodeOptions options;
    options.tile_count = 5;
    for (const Profile profile : {Profile::Small, Profile::Fast}) {
        options.profile = profile;
        SemiRegularMesh ball = bumpy_ball(5);
        for (const Vec3& p : ball.positions)
            ball.colors.push_back(
                {static_cast<std::uint8_t>(100 + 50 * p.x), 20, static_cast<std::uint8_t>(9 * p.y + 90), 255});
        const Bytes file = encode_parts({ball}, options).file;
        for (const std::size_t size : {file.size(), file.size() / 2}) {
            const ByteSpan bytes = ByteSpan(file).first(size);
            const Mesh one = decode(bytes).value(), three = decode(bytes, 255, {}, 3).value();
            EXPECT_TRUE(same(one, three));
            EXPECT_EQ(one.colors, three.colors);
        }
    }
}

TEST(Decoder, EveryLevelHasItsVertices) {
    const Bytes& file = small_file().file;
    for (unsigned level = 0; level <= 3; ++level)
        EXPECT_EQ(decode(file, level)->positions.size(), vertices_at_level(bumpy_ball(0).base, level));
}

TEST(Decoder, ChunksOfUnknownChannelsAreIgnored) {
    const Bytes& file = small_file().file;
    const Toc toc = toc_of(file);
    std::vector<ChunkToWrite> chunks;
    for (const ChunkEntry& c : toc.chunks) chunks.push_back({c.id, payload_of(file, c), c.error});
    const Bytes news(50, std::byte{42});
    chunks.insert(chunks.begin() + 2, {{0, 0, 1, 0, Channel{7}}, news, chunks[1].error});
    const Bytes newer = write_file(toc.header, chunks).value();
    EXPECT_TRUE(same(decode(newer).value(), decode(file).value()));
}

/// A file of one part whose Base payload is `payload` and whose header says 4 vertices, 4 faces.
Bytes file_with_base(const Bytes& payload) {
    FileHeader header;
    EXPECT_TRUE(set_box(header, {0, 0, 0}, 1).ok());
    header.transform = 9;
    header.layers = 1;
    header.parts = {{0, 4, 6, 4, 1}};
    return write_file(header, std::vector<ChunkToWrite>{{{}, payload, 0.1f}}).value();
}

TEST(Decoder, ABaseThatAsksForGigabytesIsRefusedBeforeDracoSeesIt) {
    for (const bool sequential : {false, true}) {
        ByteWriter base;
        base.u8(sequential ? 1 : 0);
        base.u8(0);
        base.u8(10);
        base.varint(20);
        if (!sequential) base.u8(0);
        base.varint(0x7FFFFFFF);
        base.varint(0x2AAAAAAA);
        while (base.size() < 24) base.u8(0xFF);
        EXPECT_FALSE(decode(file_with_base(base.take())).ok());
    }
}

TEST(Decoder, AGrownBaseOfTooManyFacesOrBitsIsRefused) {
    const auto read = [](unsigned flags, unsigned bits, std::uint32_t faces, std::size_t bytes) {
        ByteWriter base;
        base.u8(static_cast<std::uint8_t>(flags));
        base.u8(0);
        base.u8(static_cast<std::uint8_t>(bits));
        base.varint(bytes);
        for (std::size_t i = 0; i < bytes; ++i) base.u8(0x55);
        return read_base(base.take(), {0, faces / 2 + 2, 3 * faces / 2, faces, 1}, 9);
    };
    EXPECT_EQ(read(128, 10, 1u << 24, 65'535).error().message, "the base has more faces than its bytes can hold");
    EXPECT_EQ(read(128, 25, 4, 10).error().message, "the base's bytes make no mesh of the header's counts");
    EXPECT_EQ(read(129, 10, 4, 10).error().message, "the base's mesh is coded in two ways");
    // Few vertices, and far more faces than the memory allowed.
    Workers workers(1);
    const Limits limits{.max_memory_bytes = 100'000'000};
    PartDecoder part({0, 3, 3u << 21, 1u << 22, 1}, 9, 1, limits, workers);
    const Result<void> taken = part.take({}, Bytes(20'000), true);
    ASSERT_FALSE(taken.ok());
    EXPECT_EQ(taken.error().code, Errc::LimitExceeded);
}

TEST(Decoder, RandomBytesInTheBaseNeverCrashIt) {
    std::mt19937 random(3);
    for (int round = 0; round < 3000; ++round) {
        ByteWriter base;
        const bool sequential = random() % 4 == 0;
        base.u8(sequential ? 1 : random() % 2 == 0 ? 128 : 0);
        base.u8(0);
        base.u8(10);
        const unsigned length = 10 + random() % 60;
        base.varint(length);
        if (!sequential) base.u8(static_cast<std::uint8_t>(random() % 3));
        base.varint(4);
        base.varint(4);
        for (unsigned i = sequential ? 2 : 3; i < length; ++i)
            base.u8(static_cast<std::uint8_t>(random() % 3 == 0 ? random() : random() % 4));
        (void)decode(file_with_base(base.take())).ok();
    }
}

TEST(Decoder, BytesBehindTheEndAreRefused) {
    Bytes file = small_file().file;
    file.push_back(std::byte{0});
    Decoder decoder;
    const Result<void> r = decoder.feed(file);
    ASSERT_FALSE(r.ok());
    EXPECT_EQ(r.error().code, Errc::Malformed);
    EXPECT_TRUE(decoder.mesh().ok()) << "what was taken in stays usable";
}

TEST(Decoder, AsksForMoreUntilABaseIsThere) {
    Decoder decoder;
    EXPECT_EQ(decoder.mesh().error().code, Errc::NeedMoreData);
    ASSERT_TRUE(decoder.feed(ByteSpan(small_file().file).first(60)).ok());
    EXPECT_EQ(decoder.mesh().error().code, Errc::NeedMoreData);
    EXPECT_NE(decoder.header(), nullptr);
}

TEST(Decoder, ChunksInAnyOrderAreCompleteOnceAllAreThere) {
    const Bytes& file = small_file().file;
    const Toc toc = toc_of(file);
    Decoder decoder;
    ASSERT_TRUE(decoder.feed_header(file).ok());
    decoder.expect(toc.chunks);
    for (std::size_t i = toc.chunks.size(); i-- > 0;) {
        EXPECT_FALSE(decoder.state().complete);
        EXPECT_EQ(decoder.state().error, 1) << "nothing is sure before the file's first chunk is there";
        const ChunkEntry& c = toc.chunks[i];
        ASSERT_TRUE(decoder.feed_chunk(c.id, payload_of(file, c), c.crc32c).ok());
    }
    EXPECT_TRUE(decoder.state().complete);
    EXPECT_EQ(decoder.state().error, toc.chunks.back().error);
}

TEST(Decoder, TheErrorStatedIsThatOfWhatCameBeforeTheFirstGap) {
    const Bytes& file = small_file().file;
    const Toc toc = toc_of(file);
    ASSERT_GT(toc.chunks.size(), 3u);
    Decoder decoder;
    const ChunkId missing = toc.chunks[2].id;
    ASSERT_TRUE(decoder.feed_file(file, [&](const ChunkEntry& c) { return c.id != missing; }));
    EXPECT_FALSE(decoder.state().complete);
    EXPECT_EQ(decoder.state().error, toc.chunks[1].error);
}

TEST(Decoder, ABaseAboveTheLimitsIsRefused) {
    Limits limits;
    limits.max_vertices = 5;  // the ball's base has six
    EXPECT_FALSE(decode(small_file().file, 255, limits).ok());
}

}  // namespace
}  // namespace mvw
