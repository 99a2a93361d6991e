#include "client/view.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "client/viewer/window/live_renderer.h"

namespace mvw::client {
namespace {

// At (0, 0, 3), looking at the origin; a unit there takes half of the picture's 1,000 pixels.
View from_front() {
    View view;
    view.from_model = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -3, 1};
    view.scale_x = view.scale_y = 3;
    view.height = 1000;
    return view;
}

TEST(View, NearTilesComeBeforeFarOnes) {
    const std::vector<TilePlace> tiles{{0, 0, {0, 0, -2}, 0.1f, 0.4f, 5}, {0, 1, {0, 0, 2}, 0.1f, 0.4f, 5}};
    const auto chosen = choose_tiles(tiles, from_front());
    ASSERT_EQ(chosen.size(), 2u);
    EXPECT_GT(chosen[1].priority, chosen[0].priority);
    EXPECT_GE(chosen[0].priority, 2);
    EXPECT_EQ(chosen[0].max_level, 255) << "no error was given: nothing is left out";
}

TEST(View, CoarseTilesComeBeforeFineOnes) {
    const std::vector<TilePlace> tiles{{0, 0, {-0.5f, 0, 0}, 0.1f, 0.02f, 5}, {0, 1, {0.5f, 0, 0}, 0.1f, 0.2f, 5}};
    const auto chosen = choose_tiles(tiles, from_front());
    ASSERT_EQ(chosen.size(), 2u);
    EXPECT_GT(chosen[1].priority, chosen[0].priority);
}

TEST(View, TilesOutsideThePictureAreNotListed) {
    std::vector<TilePlace> tiles{{0, 0, {0, 0, 0}, 0.1f, 0.1f, 5}};
    for (const Vec3f middle : {Vec3f{1.2f, 0, 0}, Vec3f{0, -1.2f, 0}, Vec3f{0, 0, 3.2f}})
        tiles.push_back({0, static_cast<std::uint16_t>(tiles.size()), middle, 0.1f, 0.1f, 5});
    tiles.push_back({0, 4, {1.05f, 0, 0}, 0.1f, 0.1f, 5});
    const auto chosen = choose_tiles(tiles, from_front());
    ASSERT_EQ(chosen.size(), 2u);
    EXPECT_EQ(chosen[0].tile, 0);
    EXPECT_EQ(chosen[1].tile, 4) << "its edge reaches into the picture";
}

TEST(View, LevelsEndWhereTheyNoLongerShow) {
    // Level 0 of an edge of 0.4 at 500 pixels a unit leaves 25 pixels; each level halves it.
    const std::vector<TilePlace> tiles{{0, 0, {0, 0, 0}, 0.0f, 0.4f, 9}, {0, 1, {0, 0, -6}, 0.0f, 0.4f, 9}};
    View view = from_front();
    for (const auto& [error, near_level, far_level] :
         {std::tuple{25.1f, 0, 0}, {12.6f, 1, 0}, {1.0f, 5, 4}, {0.001f, 9, 9}}) {
        view.pixel_error = error;
        const auto chosen = choose_tiles(tiles, view);
        ASSERT_EQ(chosen.size(), 2u);
        EXPECT_EQ(chosen[0].max_level, near_level) << error;
        EXPECT_EQ(chosen[1].max_level, far_level) << error;
    }
}

TEST(View, OneTileWithAllItsLevelsLeavesNothingToChoose) {
    const std::vector<TilePlace> tile{{0, 0, {0, 0, 0}, 1, 1, 5}};
    View view = from_front();
    EXPECT_TRUE(choose_tiles(tile, view).empty());
    view.pixel_error = 1;
    EXPECT_EQ(choose_tiles(tile, view).size(), 1u);
}

TEST(View, MoreTilesThanAServerTakesAreThoseThatShowMost) {
    std::vector<TilePlace> tiles;
    for (unsigned i = 0; i < 40'000; ++i)
        tiles.push_back({0, static_cast<std::uint16_t>(i), {0, 0, 0}, 0.1f, i < 1000 ? 0.5f : 0.1f, 5});
    const auto chosen = choose_tiles(tiles, from_front());
    EXPECT_EQ(chosen.size(), protocol::MessageLimits{}.max_tiles);
    const auto is_large = [](const auto& t) { return t.tile < 1000; };
    EXPECT_EQ(std::count_if(chosen.begin(), chosen.end(), is_large), 1000);
}

TEST(Turntable, TheMiddleOfTheModelIsInTheMiddleOfWhatIsFree) {
    Turntable camera;
    camera.middle = {3, 4, 5};
    for (const double covered : {0.0, 0.3}) {
        camera.aim(1.5, covered);
        const auto& m = camera.view;
        const auto& c = camera.middle;
        const float x = m[0] * c.x + m[4] * c.y + m[8] * c.z + m[12], z = m[2] * c.x + m[6] * c.y + m[10] * c.z + m[14];
        const float on_screen = (camera.projection[0] * x + camera.projection[8] * z) / -z;
        EXPECT_NEAR(on_screen, covered, 1e-5);
    }
}

}  // namespace
}  // namespace mvw::client
