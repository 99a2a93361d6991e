#include "tools/bench/lod_hull.h"

#include <gtest/gtest.h>

namespace mvw::bench {
namespace {

TEST(LodHull, BestPsnrIsThatOfTheLargestFileThatFits) {
    const std::vector<RatePoint> hull{{100, 40, ""}, {200, 50, ""}, {400, 60, ""}};
    EXPECT_EQ(psnr_at(hull, 99), 0);
    EXPECT_EQ(psnr_at(hull, 100), 40);
    EXPECT_EQ(psnr_at(hull, 399), 50);
    EXPECT_EQ(psnr_at(hull, 10000), 60);
}

}  // namespace
}  // namespace mvw::bench
