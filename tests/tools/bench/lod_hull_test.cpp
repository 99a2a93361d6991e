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

TEST(LodHull, HullsAreReadBackFromTheTable) {
    const std::string csv =
        "model,method,bytes,psnr,bits per vertex,gain,how\n"
        "a,lod hull,100,40.5,0.1,0.00,0.40 % 8 bits\nab,lod hull,1,2,0.1,0.00,x\na,mvw,300,70,0.1,1,prefix\n"
        "a,lod hull,200,50.25,0.2,0.00,0.50 % 8 bits\n";
    const std::vector<RatePoint> hull = hull_from_csv(csv, "a");
    ASSERT_EQ(hull.size(), 2u);
    EXPECT_EQ(hull[1].bytes, 200u);
    EXPECT_EQ(hull[1].psnr, 50.25);
    EXPECT_TRUE(hull_from_csv(csv, "b").empty());
}

}  // namespace
}  // namespace mvw::bench
