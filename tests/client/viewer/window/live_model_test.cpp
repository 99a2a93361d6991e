#include "client/viewer/window/live_model.h"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/support/program.h"

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
    model.show({.level = 0, .edges = true, .base_edges = true});
    const auto base = next_frame(model);
    ASSERT_NE(base, nullptr);
    EXPECT_LT(base->drawable.triangles.size(), whole->drawable.triangles.size());
    EXPECT_EQ(base->drawable.edges.size(), base->drawable.base_edges.size());
    EXPECT_TRUE(model.settled());
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
