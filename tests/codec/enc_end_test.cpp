#include "codec/enc_end.h"

#include <gtest/gtest.h>

#include <span>

#include "codec/container/crc32c.h"
#include "codec/decoder.h"
#include "codec/enc_errors.h"
#include "codec/encoder.h"
#include "codec/part_params.h"
#include "tests/support/encoded_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

std::vector<PlannedChunk> plan_of(const Bytes& file) {
    std::vector<PlannedChunk> plan;
    for (const ChunkEntry& c : toc_of(file).chunks) {
        PlannedChunk chunk;
        chunk.id = c.id;
        const ByteSpan payload = ByteSpan(file).subspan(c.offset, c.length);
        chunk.payload.assign(payload.begin(), payload.end());
        plan.push_back(std::move(chunk));
    }
    return plan;
}

Mesh shown(const Bytes& file, std::span<const PlannedChunk> plan) {
    Decoder decoder;
    EXPECT_TRUE(decoder.feed_header(file).ok());
    for (const PlannedChunk& c : plan) EXPECT_TRUE(decoder.feed_chunk(c.id, c.payload, crc32c(c.payload)).ok());
    return decoder.mesh().value();
}

class EndTest : public ::testing::Test {
 protected:
    static const Bytes& file() {
        static const Bytes bytes = [] {
            EncodeOptions options;
            options.close = false;
            return encode(rough_torus(61, 37, 0.02), options).value().file;
        }();
        return bytes;
    }
    /// What is left of the file's plan where a mesh is what was encoded.
    static std::vector<PlannedChunk> cut(const Mesh& mesh, bool whole_chunks) {
        const std::unique_ptr<EncoderInput> input = EncoderInput::make(mesh, 1).value();
        std::vector<PlannedChunk> plan = plan_of(file());
        cut_end(*input, file(), plan, whole_chunks, 1);
        return plan;
    }
};

TEST_F(EndTest, StaysWhereAllOfItIsOfUse) {
    const std::vector<PlannedChunk> plan = plan_of(file());
    const std::vector<PlannedChunk> left = cut(shown(file(), plan), false);
    ASSERT_EQ(left.size(), plan.size());
    for (std::size_t i = 0; i < plan.size(); ++i) EXPECT_EQ(left[i].payload, plan[i].payload);
}

TEST_F(EndTest, LosesAChunkThatLeadsAway) {
    const std::vector<PlannedChunk> plan = plan_of(file());
    const auto kept = std::span(plan).first(plan.size() - 1);  // of two the last may lead back
    const std::vector<PlannedChunk> left = cut(shown(file(), kept), true);
    ASSERT_EQ(left.size(), kept.size());
    for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(left[i].id, kept[i].id);
}

TEST_F(EndTest, LosesTheEndOfAChunk) {
    std::vector<PlannedChunk> plan = plan_of(file());
    ByteReader in(plan.back().payload);
    GeometryFront front = read_geometry_front(in);
    const ByteSpan planes = in.bytes(in.remaining());
    front.beginning = true;
    const std::size_t whole = plan.back().payload.size();
    plan.back().payload = with_front(front, ByteReader(planes.first(planes.size() / 2)));
    const std::vector<PlannedChunk> left = cut(shown(file(), plan), false);
    ASSERT_EQ(left.size(), plan.size());
    EXPECT_LT(left.back().payload.size(), whole);
    EXPECT_GE(left.back().payload.size(), whole / 2);
    ByteReader payload(left.back().payload);
    EXPECT_TRUE(read_geometry_front(payload).beginning);
}

}  // namespace
}  // namespace mvw
