#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace mvw {
namespace {

using testing::HasSubstr;

TEST(PaperCommand, WritesThePageItsFiguresAndEveryNumber) {
    const ScratchFolder folder;
    const ProgramRun run = run_mvw({"paper", "--out", folder / "page", "--levels", "2", "--models", ""});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_EQ(run.out, "");
    const std::string html = read_text(folder / "page/index.html");
    for (const char* section : {"Table 1", "Table 2", "Figures 7 and 8", "Figure 6", "Figure 9", "Beyond the paper"})
        EXPECT_THAT(html, HasSubstr(section));
    // Each figure that the page shows is there.
    std::size_t figures = 0;
    for (std::size_t at = html.find("src=\""); at != std::string::npos; at = html.find("src=\"", at + 1), ++figures) {
        const std::string file = html.substr(at + 5, html.find('"', at + 5) - at - 5);
        EXPECT_TRUE(std::filesystem::exists(folder / ("page/" + file))) << file;
    }
    EXPECT_EQ(figures, 15u);
    const auto numbers = nlohmann::json::parse(read_text(folder / "page/paper.json"));
    EXPECT_NEAR(numbers["table1"]["corrected"]["ends"].get<double>(), -0.17781, 1e-5);
    EXPECT_EQ(numbers["table2"].size(), 6u);
    EXPECT_EQ(numbers["noise"]["rms"]["ball"]["interp"].size(), 3u);
    EXPECT_EQ(numbers["coding"]["ring"].size(), 11u);
    EXPECT_GT(numbers["coding"]["ring"]["seeded-normal"]["curve"][4]["psnr"].get<double>(), 60);
}

TEST(PaperCommand, NamesTheModelThatIsMissing) {
    const ScratchFolder folder;
    const ProgramRun run = run_mvw({"paper", "--out", folder / "page", "--models", folder / "none"});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.errors, HasSubstr("lucy.ply"));
}

}  // namespace
}  // namespace mvw
