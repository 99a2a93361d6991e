#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "codec/mesh/io/mesh_io.h"
#include "tests/support/program.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

TEST(BenchCommand, MakesARowAndAPictureOfEachModelAndNamesWhatFails) {
    const ScratchFolder folder;
    std::filesystem::create_directory(folder / "in");
    ASSERT_TRUE(write_mesh(folder / "in/ring.ply", torus(48, 24)).ok());
    write_text(folder / "in/broken.off", "OFF\n1 1 0\n0 0 0\n3 0 1 2\n");
    const ProgramRun run = run_mvw({"bench", "models", folder / "in", "--out", folder / "out", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto rows = nlohmann::json::parse(run.out)["models"];
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0]["model"], "broken");
    EXPECT_THAT(rows[0]["note"].get<std::string>(), testing::HasSubstr("broken.off"));
    EXPECT_EQ(rows[1]["model"], "ring");
    EXPECT_EQ(rows[1]["note"], "");
    EXPECT_EQ(rows[1]["genus"], "1");
    EXPECT_EQ(rows[1]["topology"], "kept");
    EXPECT_EQ(rows[1]["streamed"], "yes");
    EXPECT_GT(std::stod(rows[1]["PSNR dB"].get<std::string>()), 40);
    for (const char* file : {"out/models.csv", "out/models.md", "out/ring.mvw", "out/ring.png"})
        EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
}

TEST(BenchCommand, RemeshesEachModelInTwoStepsAndDrawsIt) {
    const ScratchFolder folder;
    std::filesystem::create_directory(folder / "in");
    ASSERT_TRUE(write_mesh(folder / "in/ring.ply", torus(45, 23)).ok());
    write_text(folder / "in/broken.off", "OFF\n1 1 0\n0 0 0\n3 0 1 2\n");
    const ProgramRun run = run_mvw({"bench", "remesh", folder / "in", "--out", folder / "out", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto rows = nlohmann::json::parse(run.out)["steps"];
    ASSERT_EQ(rows.size(), 3u);
    EXPECT_THAT(rows[0]["note"].get<std::string>(), testing::HasSubstr("broken.off"));
    const auto figure = [&](std::size_t row, const char* what) {
        return std::stod(rows[row][what].get<std::string>());
    };
    for (const std::size_t row : {1u, 2u}) {
        EXPECT_EQ(rows[row]["step"], row == 1 ? "remesh" : "slide");
        EXPECT_EQ(rows[row]["topology"], "kept");
        EXPECT_EQ(figure(row, "folds"), 0);
        EXPECT_EQ(figure(row, "no area"), 0);
        EXPECT_GT(figure(row, "dB"), 60);
    }
    EXPECT_LT(figure(2, "median normal"), figure(1, "median normal")) << "sliding did not make details more normal";
    for (const char* file : {"out/remesh.csv", "out/remesh.md", "out/ring.png"})
        EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
}

TEST(BenchCommand, SaysWhichFolderIsNotThere) {
    const ScratchFolder folder;
    const ProgramRun run = run_mvw({"bench", "models", folder / "none", "--out", folder / "out"});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.errors, testing::HasSubstr(folder / "none"));
}

}  // namespace
}  // namespace mvw
