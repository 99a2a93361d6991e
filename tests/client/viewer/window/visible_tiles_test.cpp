#include "client/viewer/window/visible_tiles.h"

#include <gtest/gtest.h>

namespace mvw::client {
namespace {

Turntable looking_along_minus_z() {
    Turntable camera;
    camera.yaw = camera.pitch = 0;
    camera.aim(1);
    return camera;
}

TEST(VisibleTiles, NearOnesComeBeforeFarOnes) {
    const auto seen = visible_tiles({{0, 0, {0, 0, -0.9f}, 0.1f}, {0, 1, {0, 0, 0.9f}, 0.1f}}, looking_along_minus_z());
    ASSERT_EQ(seen.size(), 2u);
    EXPECT_GE(seen[1].priority, seen[0].priority);
    EXPECT_GE(seen[0].priority, 2);
}

TEST(VisibleTiles, ThoseOutsideThePictureAreLeftToTheEnd) {
    Turntable camera = looking_along_minus_z();
    camera.zoom = 8;
    camera.aim(1);
    const auto seen = visible_tiles({{0, 0, {0, 0, 0}, 0.05f}, {0, 1, {0.9f, 0, 0}, 0.05f}}, camera);
    ASSERT_EQ(seen.size(), 1u);
    EXPECT_EQ(seen[0].tile, 0);
}

TEST(VisibleTiles, OneTileLeavesNothingToChoose) {
    EXPECT_TRUE(visible_tiles({{0, 0, {0, 0, 0}, 1}}, looking_along_minus_z()).empty());
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
