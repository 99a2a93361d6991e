#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace mvw {
namespace {

using testing::HasSubstr;

std::string square_at(double z) {
    const std::string end = " " + std::to_string(z) + "\n";
    return "OFF\n4 2 0\n0 0" + end + "1 0" + end + "1 1" + end + "0 1" + end + "3 0 1 2\n3 0 2 3\n";
}

TEST(CompareCommand, ReportsTheDistanceOfParallelSquaresAsJson) {
    const ScratchFolder folder;
    write_text(folder / "a.off", square_at(0));
    write_text(folder / "b.off", square_at(0.5));
    const ProgramRun run = run_mvw({"compare", folder / "a.off", folder / "b.off", "--samples", "1000", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto json = nlohmann::json::parse(run.out);
    EXPECT_NEAR(json["rms"].get<double>(), 0.5 / std::sqrt(2.0), 1e-9);
    EXPECT_NEAR(json["max"].get<double>(), 0.5 / std::sqrt(2.0), 1e-9);
    EXPECT_NEAR(json["psnr"].get<double>(), 20 * std::log10(std::sqrt(2.0) / 0.5), 1e-6);
    EXPECT_NEAR(json["normal_deg"].get<double>(), 0, 1e-6);
    EXPECT_EQ(run.errors, "");
}

TEST(CompareCommand, WritesAnInfinitePsnrAsNull) {
    const ScratchFolder folder;
    write_text(folder / "a.off", square_at(0));
    const ProgramRun run = run_mvw({"compare", folder / "a.off", folder / "a.off", "--samples", "1000", "--json"});
    const auto json = nlohmann::json::parse(run.out);
    EXPECT_EQ(json["rms"], 0);
    EXPECT_TRUE(json["psnr"].is_null());
}

TEST(CompareCommand, NamesTheFileThatIsMissingOrHasNoArea) {
    const ScratchFolder folder;
    write_text(folder / "a.off", square_at(0));
    write_text(folder / "flat.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n");
    for (const std::string& bad : {folder / "none.off", folder / "flat.off"}) {
        const ProgramRun run = run_mvw({"compare", folder / "a.off", bad});
        EXPECT_EQ(run.exit_code, 1);
        EXPECT_THAT(run.errors, HasSubstr(bad));
        EXPECT_EQ(run.out, "");
        EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
    }
}

TEST(CompareCommand, ExitsWithTwoOnWrongUsage) {
    EXPECT_EQ(run_mvw({"compare"}).exit_code, 2);
    EXPECT_EQ(run_mvw({"compare", "a.off", "b.off", "--samples", "many"}).exit_code, 2);
    EXPECT_EQ(run_mvw({"compare", "--help"}).exit_code, 0);
}

}  // namespace
}  // namespace mvw
