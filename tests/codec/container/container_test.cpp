#include <gtest/gtest.h>

#include <cmath>

#include <string>

#include "codec/container/crc32c.h"
#include "codec/container/enc_file.h"
#include "codec/container/toc.h"

namespace mvw {
namespace {

Bytes bytes_of(const std::string& text) {
    Bytes out;
    for (const char c : text) out.push_back(static_cast<std::byte>(c));
    return out;
}

template <typename T>
Errc code_of(const Result<T>& r) {
    EXPECT_FALSE(r.ok());
    return r.ok() ? Errc::Io : r.error().code;
}

FileHeader two_parts() {
    FileHeader h;
    EXPECT_TRUE(set_box(h, {1.0, -250.0, 0.0}, 3.0).ok());
    h.transform = 9;
    h.layers = 12;
    h.parts = {{5, 4, 6, 4, 2}, {0, 3, 3, 1, 1}};
    return h;
}

struct Sample {
    std::vector<Bytes> payloads;
    std::vector<ChunkToWrite> chunks;
    Bytes file;
};

Sample sample() {
    Sample s;
    const std::vector<ChunkId> ids = {{0, 0, 0, 0, Channel::Base},     {1, 0, 0, 0, Channel::Base},
                                      {0, 0, 1, 0, Channel::Geometry}, {0, 1, 1, 0, Channel::Geometry},
                                      {0, 1, 1, 3, Channel::Geometry}, {0, 0, 5, 2, Channel::Geometry}};
    for (std::size_t i = 0; i < ids.size(); ++i)
        s.payloads.push_back(bytes_of(std::string(40 + 50 * i, char('a' + i))));
    for (std::size_t i = 0; i < ids.size(); ++i) s.chunks.push_back({ids[i], s.payloads[i], 0.01f / float(i + 1)});
    s.file = write_file(two_parts(), s.chunks).value();
    return s;
}

ByteSpan index_of(const FileHeader& h, ByteSpan file) {
    return file.subspan(h.index_offset, h.index_bytes);
}

TEST(Crc32c, MatchesThePublishedCheckValueInAnySlices) {
    const Bytes nine = bytes_of("123456789");
    EXPECT_EQ(crc32c(nine), 0xE3069283u);
    for (std::size_t n = 0; n <= 9; ++n)
        EXPECT_EQ(crc32c(ByteSpan(nine).subspan(n), crc32c(ByteSpan(nine).first(n))), 0xE3069283u);
    EXPECT_EQ(crc32c(Bytes(32)), 0x8A9136AAu);  // RFC 3720 B.4: 32 zeros
}

TEST(Header, ReturnsWhatWasWritten) {
    const Sample s = sample();
    const FileHeader h = read_header(s.file).value();
    EXPECT_EQ(h.version, kFormatVersion);
    EXPECT_EQ(h.parts, two_parts().parts);
    EXPECT_EQ(h.transform, 9);
    EXPECT_EQ(h.layers, 12);
    EXPECT_EQ(h.file_bytes(), s.file.size());
    EXPECT_NEAR(h.diagonal, 3.0, 3.0 / 32768);
    EXPECT_GE(h.diagonal, 3.0);
    EXPECT_NEAR(h.center[1], -250.0, 3.0 / 64);
    EXPECT_LE(h.header_bytes, 64u);
}

TEST(Header, EveryPrefixAsksForMoreData) {
    const Sample s = sample();
    const std::uint32_t n = read_header(s.file)->header_bytes;
    for (std::size_t i = 0; i < n; ++i)
        EXPECT_EQ(code_of(read_header(Bytes(s.file.begin(), s.file.begin() + i))), Errc::NeedMoreData) << i;
}

TEST(Header, EveryFlippedBitIsNoticed) {
    const Sample s = sample();
    const std::uint32_t n = read_header(s.file)->header_bytes;
    for (std::size_t bit = 0; bit < 8 * n; ++bit) {
        Bytes file = s.file;
        file[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
        EXPECT_FALSE(read_header(file).ok()) << "bit " << bit;
    }
}

/// Changes a byte of the header and makes its check right again.
Bytes forged(Bytes file, std::size_t at, std::uint8_t value) {
    const std::uint32_t n = read_header(file)->header_bytes;
    file[at] = std::byte{value};
    const std::uint32_t crc = crc32c(ByteSpan(file).first(n - 2));
    file[n - 2] = static_cast<std::byte>(crc);
    file[n - 1] = static_cast<std::byte>(crc >> 8);
    return file;
}

TEST(Header, UnknownVersionAndFeaturesAreRefused) {
    const Bytes file = sample().file;
    EXPECT_EQ(code_of(read_header(forged(file, 3, kFormatVersion + 1))), Errc::Unsupported);
    EXPECT_EQ(code_of(read_header(forged(file, 5, 1))), Errc::Unsupported);
    EXPECT_EQ(code_of(read_header(bytes_of("solid cube"))), Errc::Malformed);
    EXPECT_EQ(code_of(read_header({})), Errc::NeedMoreData);
}

TEST(Header, LimitsAreEnforced) {
    const Bytes file = sample().file;
    const auto with = [&](auto change) {
        Limits limits;
        change(limits);
        return code_of(read_header(file, limits));
    };
    EXPECT_EQ(with([](Limits& l) { l.max_parts = 1; }), Errc::LimitExceeded);
    EXPECT_EQ(with([](Limits& l) { l.max_levels = 4; }), Errc::LimitExceeded);
    EXPECT_EQ(with([](Limits& l) { l.max_base_faces = 4; }), Errc::LimitExceeded);
    EXPECT_EQ(with([](Limits& l) { l.max_tiles = 1; }), Errc::LimitExceeded);
    EXPECT_EQ(with([](Limits& l) { l.max_layers = 11; }), Errc::LimitExceeded);
}

TEST(Header, AnyByteForgedIsReadOrRefusedButNeverTrustedBlindly) {
    const Bytes file = sample().file;
    const std::uint32_t n = read_header(file)->header_bytes;
    for (std::size_t at = 4; at < n - 2; ++at)
        for (unsigned value = 0; value < 256; ++value) {
            const Result<FileHeader> h = read_header(forged(file, at, static_cast<std::uint8_t>(value)));
            if (h.ok() && h->file_bytes() <= file.size()) (void)read_toc(*h, index_of(*h, file), file.size()).ok();
        }
}

TEST(Header, BoxesFarAwayHugeAndTinyAreHeld) {
    for (const double size : {0.02, 1e-30, 1e30}) {
        FileHeader h = two_parts();
        ASSERT_TRUE(set_box(h, {1e6 * size, 0, -5e7 * size}, size).ok());
        const Sample s = sample();
        const FileHeader back = read_header(write_file(h, s.chunks).value()).value();
        EXPECT_EQ(back.diagonal, h.diagonal);
        EXPECT_EQ(back.center, h.center);
    }
    FileHeader h;
    EXPECT_EQ(code_of(set_box(h, {0, 0, 0}, 0)), Errc::InvalidArgument);
    EXPECT_EQ(code_of(set_box(h, {0, 0, 0}, INFINITY)), Errc::InvalidArgument);
}

TEST(Toc, PointsAtEveryPayload) {
    const Sample s = sample();
    const FileHeader h = read_header(s.file).value();
    const Toc toc = read_toc(h, index_of(h, s.file), s.file.size()).value();
    ASSERT_EQ(toc.chunks.size(), s.chunks.size());
    for (std::size_t i = 0; i < toc.chunks.size(); ++i) {
        const ChunkEntry& c = toc.chunks[i];
        EXPECT_EQ(c.id, s.chunks[i].id);
        const ByteSpan payload = ByteSpan(s.file).subspan(c.offset, c.length);
        EXPECT_TRUE(std::equal(payload.begin(), payload.end(), s.payloads[i].begin(), s.payloads[i].end()));
        EXPECT_EQ(c.crc32c, crc32c(payload));
        EXPECT_NEAR(c.error, s.chunks[i].error, 0.001 * s.chunks[i].error);
    }
}

TEST(Toc, HeadsBetweenThePayloadsSayTheSame) {
    const Sample s = sample();
    ByteReader in(s.file);
    in.bytes(read_header(s.file)->header_bytes);
    ChunkId previous;
    for (const ChunkToWrite& c : s.chunks) {
        const std::size_t start = in.offset();
        const ChunkHead head = read_chunk_head(in, previous).value();
        EXPECT_EQ(head.id, c.id);
        const ByteSpan fields = ByteSpan(s.file).subspan(start, in.offset() - start - 2);
        const ByteSpan payload = in.bytes(head.length);
        EXPECT_EQ(head.check, chunk_check(fields, payload));
        previous = head.id;
    }
    EXPECT_EQ(in.offset(), read_header(s.file)->index_offset);
}

TEST(Toc, EveryFlippedByteOfTheIndexIsNoticed) {
    const Sample s = sample();
    const FileHeader h = read_header(s.file).value();
    for (std::size_t i = h.index_offset; i < s.file.size(); ++i) {
        Bytes file = s.file;
        file[i] ^= std::byte{0x40};
        EXPECT_FALSE(read_toc(h, index_of(h, file), file.size()).ok()) << "byte " << i;
    }
    EXPECT_EQ(code_of(read_toc(h, index_of(h, s.file), s.file.size() - 1)), Errc::Malformed);
    EXPECT_EQ(code_of(read_toc(h, index_of(h, s.file).first(3), s.file.size())), Errc::Malformed);
}

TEST(Toc, LimitsAreEnforced) {
    const Sample s = sample();
    const FileHeader h = read_header(s.file).value();
    Limits few, small;
    few.max_chunks = 5;
    small.max_chunk_bytes = 100;
    EXPECT_EQ(code_of(read_toc(h, index_of(h, s.file), s.file.size(), few)), Errc::LimitExceeded);
    EXPECT_EQ(code_of(read_toc(h, index_of(h, s.file), s.file.size(), small)), Errc::LimitExceeded);
}

TEST(WriteFile, RefusesChunksThatNoDecoderCouldUse) {
    Sample s = sample();
    const auto write = [&](const std::vector<std::size_t>& order) {
        std::vector<ChunkToWrite> chunks;
        chunks.reserve(order.size());
        for (const std::size_t i : order) chunks.push_back(s.chunks[i]);
        return write_file(two_parts(), chunks);
    };
    EXPECT_TRUE(write({0, 1, 5, 3}).ok());
    EXPECT_TRUE(write({0, 4}).ok()) << "layers may skip numbers";
    EXPECT_TRUE(write({}).ok());
    EXPECT_EQ(code_of(write({2, 0})), Errc::Malformed) << "base must come first";
    EXPECT_EQ(code_of(write({0, 4, 3})), Errc::Malformed) << "layer 3 before layer 0";
    EXPECT_EQ(code_of(write({0, 2, 2})), Errc::Malformed) << "twice the same";
    s.chunks[2].id.tile = 2;
    EXPECT_EQ(code_of(write({0, 2})), Errc::Malformed) << "no such tile";
}

TEST(WriteFile, ContentIdNamesChunksAndBoxButNotItself) {
    const Sample s = sample();
    EXPECT_EQ(content_id_of(s.file).value(), read_header(s.file)->content_id);
    FileHeader larger = two_parts();
    ASSERT_TRUE(set_box(larger, {1, -250, 0}, 6).ok());
    EXPECT_NE(read_header(write_file(larger, s.chunks).value())->content_id, read_header(s.file)->content_id);
    Bytes damaged = s.file;
    damaged[100] ^= std::byte{1};
    EXPECT_NE(content_id_of(damaged).value(), read_header(damaged)->content_id);
}

TEST(WriteFile, WhatIsNotPayloadStaysSmall) {
    Sample s = sample();
    const Bytes kilobyte(1000);
    std::vector<ChunkToWrite> chunks = {{{}, kilobyte, 0.1f}};
    for (std::uint8_t layer = 0; layer < 12; ++layer)
        chunks.push_back({{0, 1, 3, layer, Channel::Geometry}, kilobyte, 0.1f});
    const Bytes file = write_file(two_parts(), chunks).value();
    EXPECT_LT(file.size() - 1000 * chunks.size(), 300u);
}

}  // namespace
}  // namespace mvw
