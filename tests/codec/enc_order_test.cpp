#include "codec/enc_order.h"

#include <gtest/gtest.h>

#include "codec/container/enc_file.h"
#include "codec/decoder.h"
#include "codec/part_params.h"
#include "tests/support/encoded_models.h"

namespace mvw {
namespace {

PlannedChunk chunk(Channel channel, unsigned level, unsigned top_plane, unsigned lowest_plane, double gain,
                   bool needs_parent = false) {
    PlannedChunk out;
    out.id.channel = channel;
    out.id.level = static_cast<std::uint8_t>(level);
    out.id.layer = channel == Channel::Base ? std::uint8_t{0} : static_cast<std::uint8_t>(9 - lowest_plane);
    out.payload.resize(94);  // 100 bytes with its head
    out.top_plane = top_plane;
    out.lowest_plane = lowest_plane;
    out.gain = gain;
    out.needs_parent = needs_parent;
    return out;
}

/// Places in the given plan, in the order that sorting brings them to.
std::vector<std::size_t> sorted(std::vector<PlannedChunk> plan) {
    for (std::size_t i = 0; i < plan.size(); ++i) plan[i].payload[0] = static_cast<std::byte>(i);
    sort_chunks(plan);
    std::vector<std::size_t> order;
    for (const PlannedChunk& c : plan) order.push_back(std::to_integer<std::size_t>(c.payload[0]));
    return order;
}

using Order = std::vector<std::size_t>;

TEST(SortChunks, ByFallingGainAByteBehindTheBases) {
    std::vector<PlannedChunk> plan{chunk(Channel::Base, 0, 0, 0, 0), chunk(Channel::Geometry, 1, 9, 9, 2),
                                   chunk(Channel::Geometry, 2, 9, 9, 4), chunk(Channel::Geometry, 3, 9, 9, 3)};
    EXPECT_EQ(sorted(plan), (Order{0, 2, 3, 1}));
    plan[1].payload.resize(14);  // a fifth of the bytes for half of the gain
    EXPECT_EQ(sorted(plan), (Order{0, 1, 2, 3}));
}

TEST(SortChunks, BehindWhatTheyBuildOn) {
    const std::vector<PlannedChunk> plan{
        chunk(Channel::Base, 0, 0, 0, 0),
        chunk(Channel::Geometry, 1, 9, 7, 1),  // its planes above 6 are what the third one looks at
        chunk(Channel::Geometry, 1, 6, 6, 0.5),
        chunk(Channel::Geometry, 2, 6, 6, 8, true),
        chunk(Channel::Geometry, 2, 5, 5, 9),  // follows the one before in its block
    };
    EXPECT_EQ(sorted(plan), (Order{0, 1, 3, 4, 2}));
}

TEST(SortChunks, AttributesBehindTheirDescription) {
    const std::vector<PlannedChunk> plan{chunk(Channel::Base, 0, 0, 0, 0), chunk(Channel::Attributes, 0, 0, 0, 0),
                                         chunk(Channel::Geometry, 1, 9, 9, 5), chunk(Channel::Color, 1, 9, 9, 4)};
    EXPECT_EQ(sorted(plan), (Order{0, 2, 1, 3}));
}

TEST(SortChunks, SaysWhatErrorIsLeft) {
    std::vector<PlannedChunk> plan{chunk(Channel::Base, 0, 0, 0, 0), chunk(Channel::Geometry, 1, 9, 9, 2),
                                   chunk(Channel::Geometry, 2, 9, 9, 4), chunk(Channel::Color, 0, 9, 9, 3)};
    plan[0].error = 10;
    sort_chunks(plan);
    std::vector<double> errors;
    errors.reserve(plan.size());
    for (const PlannedChunk& c : plan) errors.push_back(c.error);
    EXPECT_EQ(errors, (std::vector<double>{10, 6, 6, 4}));
}

TEST(JoinChunks, HoldWhatBothDid) {
    const Bytes& file = fine_file().file;
    const Toc toc = toc_of(file);
    std::vector<PlannedChunk> plan;
    for (const ChunkEntry& c : toc.chunks) {
        PlannedChunk& chunk = plan.emplace_back();
        chunk.id = c.id;
        const ByteSpan payload = payload_of(file, c);
        chunk.payload.assign(payload.begin(), payload.end());
        ByteReader in(payload);
        if (c.id.channel != Channel::Geometry) continue;
        const GeometryFront front = read_geometry_front(in);
        chunk.top_plane = front.top_plane;
        chunk.lowest_plane = toc.header.layers - 1u - c.id.layer;
        chunk.needs_parent = front.needs_parent;
    }
    // Each chunk of level 2 into the next one.
    std::size_t last = 0, joined = 0;
    for (std::size_t i = 0; i < plan.size(); ++i) {
        if (plan[i].id.channel != Channel::Geometry || plan[i].id.level != 2) continue;
        if (last > 0) {
            plan[i] = join_chunks(plan[last], plan[i]);
            plan.erase(plan.begin() + std::ptrdiff_t(last));
            --i, ++joined;
        }
        last = i;
    }
    ASSERT_GT(joined, 0u);
    std::vector<ChunkToWrite> chunks;
    for (const PlannedChunk& c : plan) chunks.push_back({c.id, c.payload, 0.5f});
    Decoder decoder;
    ASSERT_TRUE(decoder.feed(write_file(toc.header, chunks).value()).ok());
    EXPECT_TRUE(decoder.state().complete);
    EXPECT_EQ(decoder.mesh()->positions, decode(file)->positions);
}

}  // namespace
}  // namespace mvw
