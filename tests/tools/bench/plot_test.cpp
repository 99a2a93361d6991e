#include "tools/bench/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mvw::bench {
namespace {

using testing::HasSubstr;

TEST(Plot, DrawsEachCurveWithItsNameAndPoints) {
    const Plot plot{"a < b", "bytes", "dB", {{"one", {{100, 40}, {1000, 50}}}, {"two", {{100, 45}}}}};
    const std::string svg = plot.svg();
    EXPECT_THAT(svg, HasSubstr("a &lt; b"));
    EXPECT_THAT(svg, HasSubstr(">one<"));
    EXPECT_THAT(svg, HasSubstr(">two<"));
    std::size_t circles = 0;
    for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) ++circles;
    EXPECT_EQ(circles, 3u);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Plot, OfNothingIsStillAPicture) {
    const std::string svg = Plot{"empty", "x", "y", {}}.svg();
    EXPECT_THAT(svg, HasSubstr("</svg>"));
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
}

}  // namespace
}  // namespace mvw::bench
