#include "tools/paper/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mvw::paper {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Chart, DrawsEachLineWithItsNameAndDots) {
    const Chart chart{"a < b", "analyses", "error",
                      false,   false,      {{"one & two", {{0, 1}, {1, 3}, {2, 2}}}, {"flat", {{0, 2}, {2, 2}}}}};
    const std::string svg = chart.svg();
    EXPECT_THAT(svg, HasSubstr("a &lt; b"));
    EXPECT_THAT(svg, HasSubstr("one &amp; two"));
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    std::size_t dots = 0;
    for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) ++dots;
    EXPECT_EQ(dots, 5u);
}

TEST(Chart, HasRoundTicksOnBothKindsOfAxis) {
    const std::string svg = Chart{"", "", "", true, false, {{"", {{0.3, 41}, {30, 78}}}}}.svg();
    for (const char* tick : {">1<", ">10<", ">50<", ">70<"}) EXPECT_THAT(svg, HasSubstr(tick));
    EXPECT_THAT(svg, Not(HasSubstr(">41<")));
}

TEST(Chart, SurvivesASinglePointAndNone) {
    EXPECT_THAT((Chart{"", "", "", true, true, {{"", {{2, 2}}}}}.svg()), Not(HasSubstr("nan")));
    EXPECT_THAT(Chart{}.svg(), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace mvw::paper
