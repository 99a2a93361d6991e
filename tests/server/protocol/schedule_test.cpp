#include "server/protocol/schedule.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/stream_models.h"

namespace mvw::protocol {
namespace {

struct Walk {
    std::vector<std::uint32_t> order;
    EndReason reason;
};

Walk walk(const Toc& toc, const Request& request) {
    Schedule schedule(toc, request);
    ChunkSet sent = request.held;
    Walk w;
    while (const auto index = schedule.next(sent)) {
        w.order.push_back(*index);
        sent.insert(*index);
    }
    w.reason = schedule.end_reason();
    return w;
}

class ScheduleTest : public testing::Test {
 protected:
    const std::shared_ptr<test::MemoryModel> model_ = test::MemoryModel::make(test::make_stream_file());
    const Toc& toc_ = model_->toc();
};

TEST_F(ScheduleTest, AllOfItIsFileOrder) {
    const Walk w = walk(toc_, {});
    ASSERT_EQ(w.order.size(), toc_.chunks.size());
    for (std::uint32_t i = 0; i < w.order.size(); ++i) EXPECT_EQ(w.order[i], i);
    EXPECT_EQ(w.reason, EndReason::Complete);
}

TEST_F(ScheduleTest, AClosingPartComesLastToThoseWhoWantEverything) {
    Toc toc = toc_;
    PartInfo closing = toc.header.parts[0];
    closing.levels = 0;
    closing.supersedes = true;
    toc.header.parts.push_back(closing);
    const auto count = static_cast<std::uint32_t>(toc.chunks.size());
    toc.chunks.push_back({{1, 0, 0, 0, Channel::Base}, 0, 10, 0, 0.001f});
    toc.chunks.push_back({{1, 1, 0, 3, Channel::Geometry}, 0, 10, 0, 0.0005f});
    Request all;
    all.tiles = {{0, 2, 9, 255}};
    const Walk w = walk(toc, all);
    ASSERT_EQ(w.order.size(), count + 2);
    EXPECT_EQ(w.order[count], count);
    EXPECT_EQ(w.order[count + 1], count + 1);
    Request coarse, layers, some, far;
    far.tiles = {{0, 2, 9, 1}};
    coarse.max_level = toc.header.parts[0].levels;
    layers.max_layer = static_cast<std::uint8_t>(toc.header.layers - 2);
    some.tiles = all.tiles;
    some.other_priority = 0;
    for (const Request& r : {coarse, layers, some, far})
        for (const std::uint32_t i : walk(toc, r).order) EXPECT_LT(i, count);
}

TEST_F(ScheduleTest, SplitsComeWithBasesToEveryView) {
    Toc toc;
    toc.header.layers = 4;
    toc.header.parts = {{0, 40, 114, 76, 2, 0, false, false, true}};
    toc.chunks.push_back({{0, 0, 0, 0, Channel::Base}, 0, 10, 0, 0.1f});
    for (std::uint8_t k = 0; k < 6; ++k) toc.chunks.push_back({{0, 0, 0, k, Channel::Splits}, 0, 10, 0, 0.05f});
    for (std::uint8_t layer = 2; layer < 4; ++layer)
        for (std::uint16_t tile = 0; tile < 2; ++tile)
            toc.chunks.push_back({{0, tile, 0, layer, Channel::Geometry}, 0, 10, 0, 0.01f});
    Request near;  // a part of the surface, and nothing else
    near.tiles = {{0, 0, 9, 3}};
    near.other_priority = 0;
    EXPECT_EQ(walk(toc, near).order, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7, 9}));
    Request layers;
    layers.max_layer = 2;
    EXPECT_EQ(walk(toc, layers).order, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST_F(ScheduleTest, HeldChunksAreLeftOut) {
    Request r;
    for (const std::uint32_t i : {0u, 1u, 2u, 9u}) r.held.insert(i);
    const Walk w = walk(toc_, r);
    EXPECT_EQ(w.order.size(), toc_.chunks.size() - 4);
    for (const std::uint32_t i : w.order) EXPECT_FALSE(r.held.contains(i));
}

TEST_F(ScheduleTest, LevelAndLayerAreCaps) {
    Request r;
    r.max_level = 1;
    r.max_layer = 2;
    const Walk w = walk(toc_, r);
    EXPECT_EQ(w.order.size(), 1u + 2 * 3 * 4);  // base, levels 0 and 1, layers 0 to 2, 4 tiles
    for (const std::uint32_t i : w.order) {
        EXPECT_LE(toc_.chunks[i].id.level, 1);
        EXPECT_LE(toc_.chunks[i].id.layer, 2);
    }
}

TEST_F(ScheduleTest, BudgetIsNeverExceededAndUsedUpToTheChunkThatDoesNotFit) {
    for (const std::uint64_t budget : {1u, 500u, 3000u, 7777u}) {
        Request r;
        r.byte_budget = budget;
        const Walk w = walk(toc_, r);
        std::uint64_t bytes = toc_.header.header_bytes;
        for (const std::uint32_t i : w.order) bytes += toc_.chunks[i].length;
        EXPECT_TRUE(w.order.empty() || bytes <= budget);
        EXPECT_GT(bytes + toc_.chunks[w.order.size()].length, budget);
        EXPECT_EQ(w.reason, EndReason::Budget);
    }
}

TEST_F(ScheduleTest, BudgetCountsWhatIsHeld) {
    Request r;
    r.byte_budget = 5000;
    const Walk whole = walk(toc_, r);
    ASSERT_GT(whole.order.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) r.held.insert(whole.order[i]);
    const Walk rest = walk(toc_, r);
    EXPECT_EQ(rest.order, std::vector<std::uint32_t>(whole.order.begin() + 4, whole.order.end()));
}

TEST_F(ScheduleTest, TargetErrorEndsWithTheChunkThatMeetsIt) {
    Request r;
    r.target_error = 0.05f;
    const Walk w = walk(toc_, r);
    ASSERT_FALSE(w.order.empty());
    EXPECT_LE(toc_.chunks[w.order.back()].error, 0.05f);
    EXPECT_GT(toc_.chunks[w.order.back() - 1].error, 0.05f);
    EXPECT_EQ(w.reason, EndReason::Complete);
}

TEST_F(ScheduleTest, TilesComeByPriorityAfterTheBase) {
    Request r;
    r.tiles = {{0, 2, 9, 255}, {0, 1, 5, 255}};
    const Walk w = walk(toc_, r);
    ASSERT_EQ(w.order.size(), toc_.chunks.size());
    EXPECT_EQ(toc_.chunks[w.order[0]].id.channel, Channel::Base);
    const std::size_t per_tile = (toc_.chunks.size() - 1) / 4;
    for (std::size_t i = 0; i < per_tile; ++i) EXPECT_EQ(toc_.chunks[w.order[1 + i]].id.tile, 2);
    for (std::size_t i = 0; i < per_tile; ++i) EXPECT_EQ(toc_.chunks[w.order[1 + per_tile + i]].id.tile, 1);
    EXPECT_EQ(std::set<std::uint32_t>(w.order.begin(), w.order.end()).size(), w.order.size());
}

TEST_F(ScheduleTest, PriorityZeroMeansNotAtAllAndATileHasALevelOfItsOwn) {
    Request r;
    r.other_priority = 0;
    r.tiles = {{0, 3, 1, 1}, {0, 0, 0, 255}};
    const Walk w = walk(toc_, r);
    EXPECT_EQ(w.order.size(), 1u + 2 * 4);
    for (std::size_t i = 1; i < w.order.size(); ++i) {
        EXPECT_EQ(toc_.chunks[w.order[i]].id.tile, 3);
        EXPECT_LE(toc_.chunks[w.order[i]].id.level, 1);
    }
}

TEST_F(ScheduleTest, LevelsThatAreNotTiledComeWhateverTheTiles) {
    Toc toc = toc_;
    toc.header.parts[0].first_tiled_level = 1;
    Request r;
    r.other_priority = 0;
    r.tiles = {{0, 3, 1, 255}};
    bool level_0 = false;
    for (const std::uint32_t i : walk(toc, r).order) {
        const ChunkId& id = toc.chunks[i].id;
        if (id.channel == Channel::Base) continue;
        level_0 |= id.level == 0 && id.tile == 0;
        EXPECT_TRUE(id.level == 0 || id.tile == 3);
    }
    EXPECT_TRUE(level_0);
}

TEST_F(ScheduleTest, LayersOfATileKeepTheirOrder) {
    Request r;
    r.tiles = {{0, 2, 9, 255}, {0, 1, 5, 1}, {0, 0, 7, 255}};
    std::map<std::pair<int, int>, int> last;
    for (const std::uint32_t i : walk(toc_, r).order) {
        const ChunkId& id = toc_.chunks[i].id;
        if (id.channel == Channel::Base) continue;
        int& layers = last[{id.tile, id.level}];
        EXPECT_EQ(id.layer, layers);
        ++layers;
    }
}

}  // namespace
}  // namespace mvw::protocol
