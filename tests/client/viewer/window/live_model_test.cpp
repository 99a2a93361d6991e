#include "client/viewer/window/live_model.h"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/support/encoded_models.h"
#include "tests/support/program.h"
#include "tests/support/stream_models.h"

namespace mvw::client {
namespace {

using namespace std::chrono_literals;

std::unique_ptr<LiveFrame> next_frame(LiveModel& model) {
    for (int i = 0; i < 2000; ++i) {
        if (auto frame = model.take()) return frame;
        std::this_thread::sleep_for(5ms);
    }
    return nullptr;
}

TEST(LiveModel, AFileIsShownWholeWithItsCurve) {
    LiveModel model(test_data_folder() + "/golden_mixed.mvw", {});
    const auto frame = next_frame(model);
    ASSERT_NE(frame, nullptr);
    EXPECT_TRUE(model.ended());
    EXPECT_EQ(model.message(), "");
    EXPECT_EQ(frame->parts, 3u);
    EXPECT_EQ(frame->drawable.parts, 3u);
    EXPECT_FALSE(frame->curve.empty());
    EXPECT_EQ(frame->drawable.level, frame->levels);
}

TEST(LiveModel, AnotherLevelAndLinesComeWhenAskedFor) {
    LiveModel model(test_data_folder() + "/golden_mixed.mvw", {});
    const auto whole = next_frame(model);
    ASSERT_NE(whole, nullptr);
    model.show({.lines = {.level = 0, .edges = true, .base_edges = true}});
    const auto base = next_frame(model);
    ASSERT_NE(base, nullptr);
    EXPECT_LT(base->drawable.triangles.size(), whole->drawable.triangles.size());
    EXPECT_EQ(base->drawable.edges.size(), base->drawable.base_edges.size());
    EXPECT_TRUE(model.settled());
}

TEST(LiveModel, FewerLayersOrBytesShowLessOfIt) {
    const test::TemporaryFolder folder;
    folder.put("a.mvw", small_file().file);
    LiveModel model(folder.path("a.mvw"), {});
    const auto whole = next_frame(model);
    ASSERT_NE(whole, nullptr);
    EXPECT_GT(whole->layers, 1u);
    model.show({.lines = {}, .layer = 0});
    const auto coarse = next_frame(model);
    ASSERT_NE(coarse, nullptr);
    EXPECT_LT(coarse->state.chunks, whole->state.chunks);
    EXPECT_EQ(coarse->drawable.triangles.size(), whole->drawable.triangles.size());
    EXPECT_NE(coarse->drawable.positions, whole->drawable.positions);
    model.show({.lines = {}, .bytes = static_cast<double>(whole->file_bytes) / 2});
    const auto half = next_frame(model);
    ASSERT_NE(half, nullptr);
    EXPECT_LT(half->state.chunks, whole->state.chunks);
    EXPECT_EQ(half->arrived, whole->arrived);
}

TEST(LiveModel, AFileComesAtThePaceAskedFor) {
    const test::TemporaryFolder folder;
    folder.put("a.mvw", small_file().file);
    const auto bytes = static_cast<double>(small_file().file.size());
    const auto pace = std::make_shared<Pace>();
    pace->bytes_per_second = 2 * bytes;
    StreamOptions options;
    options.pace = pace;
    const auto begun = Clock::now();
    LiveModel model(folder.path("a.mvw"), options);
    const auto first = next_frame(model);
    ASSERT_NE(first, nullptr);
    EXPECT_FALSE(model.ended());
    while (!model.ended()) std::this_thread::sleep_for(5ms);
    EXPECT_GE(std::chrono::duration<double>(Clock::now() - begun).count(), 0.4);
}

TEST(LiveModel, SaysWhyThereIsNothingToShow) {
    for (const char* place : {"no_such_file.mvw", "mvw://127.0.0.1", "ftp://host/model"}) {
        LiveModel model(place, {});
        for (int i = 0; i < 400 && !model.ended(); ++i) std::this_thread::sleep_for(5ms);
        EXPECT_TRUE(model.ended()) << place;
        EXPECT_NE(model.message(), "") << place;
        EXPECT_EQ(model.take(), nullptr);
    }
}

}  // namespace
}  // namespace mvw::client
