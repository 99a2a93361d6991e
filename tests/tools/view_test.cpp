#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb_image.h>

#include "codec/mesh/io/mesh_io.h"
#include "tests/support/program.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

constexpr const char* kTetrahedron = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

TEST(ViewCommand, WritesAPictureOfTheSizeAskedFor) {
    const ScratchFolder folder;
    write_text(folder / "a.off", kTetrahedron);
    const ProgramRun run =
        run_mvw({"view", folder / "a.off", "--screenshot", folder / "a.png", "--size", "120x80", "--wireframe"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    int w = 0, h = 0, n = 0;
    EXPECT_NE(stbi_info((folder / "a.png").c_str(), &w, &h, &n), 0);
    EXPECT_EQ(w, 120);
    EXPECT_EQ(h, 80);
}

TEST(ViewCommand, DrawsTheLevelAskedForOfAnEncodedModel) {
    const ScratchFolder folder;
    ASSERT_TRUE(write_mesh(folder / "a.ply", torus(48, 24)).ok());
    ASSERT_EQ(run_mvw({"encode", folder / "a.ply", folder / "a.mvw"}).exit_code, 0);
    const auto draw = [&](const std::vector<std::string>& extra) {
        std::vector<std::string> arguments{"view",           folder / "a.mvw", "--screenshot",
                                           folder / "a.png", "--size",         "99x99"};
        arguments.insert(arguments.end(), extra.begin(), extra.end());
        EXPECT_EQ(run_mvw(arguments).exit_code, 0);
        return read_text(folder / "a.png");
    };
    EXPECT_NE(draw({}), draw({"--level", "0"}));
    EXPECT_EQ(run_mvw({"view", folder / "a.ply", "--screenshot", folder / "b.png", "--level", "0"}).exit_code, 2);
}

TEST(ViewCommand, SaysWhatIsWrongWithItsArguments) {
    const ScratchFolder folder;
    write_text(folder / "a.off", kTetrahedron);
    EXPECT_EQ(run_mvw({"view", folder / "a.off"}).exit_code, 2);
    EXPECT_THAT(run_mvw({"view", folder / "a.off"}).errors, testing::HasSubstr("--screenshot"));
    for (const char* size : {"12", "12x", "x12", "12x12x", "0x10", "99999x10"}) {
        const ProgramRun run = run_mvw({"view", folder / "a.off", "--screenshot", folder / "b.png", "--size", size});
        EXPECT_EQ(run.exit_code, 2) << size;
        EXPECT_EQ(read_text(folder / "b.png"), "");
    }
}

TEST(ViewCommand, NamesTheFileThatItCannotReadOrWrite) {
    const ScratchFolder folder;
    write_text(folder / "a.off", kTetrahedron);
    const ProgramRun missing = run_mvw({"view", folder / "b.off", "--screenshot", folder / "a.png"});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_THAT(missing.errors, testing::HasSubstr(folder / "b.off"));
    const ProgramRun nowhere = run_mvw({"view", folder / "a.off", "--screenshot", folder / "no/where.png"});
    EXPECT_EQ(nowhere.exit_code, 1);
    EXPECT_THAT(nowhere.errors, testing::HasSubstr(folder / "no/where.png"));
}

}  // namespace
}  // namespace mvw
