#include "codec/dec_original.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "codec/decoder.h"
#include "codec/enc_original.h"
#include "tests/support/encoded_models.h"
#include "tests/support/semi_regular_models.h"

namespace mvw {
namespace {

Encoded with_original(unsigned bits) {
    EncodeOptions options;
    options.keep_original = bits;
    return encode_parts({bumpy_ball(3)}, options);
}

TEST(Original, ComesBackToItsPrecisionWithAllItsFaces) {
    const Mesh input = plain(bumpy_ball(3));
    const Encoded e = with_original(16);
    EXPECT_GT(e.original_bytes, 0u);
    const Mesh back = decode_original(e.file).value();
    ASSERT_EQ(back.positions.size(), input.positions.size());
    ASSERT_EQ(back.faces.size(), input.faces.size());
    const double step = bounding_box(input).diagonal() / 65536;
    for (const Vec3& p : input.positions) {
        const auto near = [&](const Vec3& q) { return length(p - q) < step; };
        EXPECT_TRUE(std::any_of(back.positions.begin(), back.positions.end(), near));
    }
}

TEST(Original, IsTheLastChunkAndChangesNothingBefore) {
    const Bytes with = with_original(12).file, without = with_original(0).file;
    const Toc toc = toc_of(with);
    EXPECT_EQ(toc.chunks.back().id.channel, Channel::Original);
    EXPECT_EQ(toc.chunks.size(), toc_of(without).chunks.size() + 1);
    EXPECT_EQ(decode(with)->positions, decode(without)->positions);
}

TEST(Original, FilesWithoutItAndCutFilesSaySo) {
    const Bytes file = with_original(12).file;
    EXPECT_EQ(decode_original(with_original(0).file).error().code, Errc::InvalidArgument);
    EXPECT_EQ(decode_original(ByteSpan(file).first(file.size() - 1)).error().code, Errc::NeedMoreData);
}

TEST(Original, CountsAboveTheLimitsAreRefusedBeforeDracoRuns) {
    const Bytes file = with_original(12).file;
    const ChunkEntry chunk = toc_of(file).chunks.back();
    Limits limits;
    limits.max_vertices = 100;
    EXPECT_EQ(read_original(payload_of(file, chunk), toc_of(file).header, limits).error().code, Errc::LimitExceeded);
    for (std::size_t n = 0; n < chunk.length; n += 5)
        EXPECT_FALSE(read_original(payload_of(file, chunk).first(n), toc_of(file).header).ok()) << n;
}

}  // namespace
}  // namespace mvw
