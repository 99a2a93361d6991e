#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/mesh/io/mesh_io.h"
#include "tests/support/program.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

TEST(SubdivideCommand, RefinesAMeshAndKeepsItsVertices) {
    const ScratchFolder folder;
    const Mesh ring = torus(8, 6);
    ASSERT_TRUE(write_mesh(folder / "ring.ply", ring).ok());
    const ProgramRun run =
        run_mvw({"subdivide", folder / "ring.ply", folder / "fine.ply", "--levels", "2", "--shape", "1"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    CleanReport report;
    const auto fine = read_mesh(folder / "fine.ply", report);
    ASSERT_TRUE(fine.ok());
    EXPECT_EQ(fine->faces.size(), 16 * ring.faces.size());
    for (std::size_t v = 0; v < ring.positions.size(); ++v)
        EXPECT_LT(length(fine->positions[v] - ring.positions[v]), 1e-6);
}

TEST(SubdivideCommand, RefusesASOutOfRangeAndNamesAFileItCannotRead) {
    const ScratchFolder folder;
    EXPECT_EQ(run_mvw({"subdivide", "a.ply", "b.ply", "--s", "1.5"}).exit_code, 2);
    EXPECT_EQ(run_mvw({"subdivide", "a.ply", "b.ply", "--s", "0"}).exit_code, 2);
    const ProgramRun run = run_mvw({"subdivide", folder / "none.ply", folder / "out.ply"});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.errors, testing::HasSubstr("none.ply"));
}

}  // namespace
}  // namespace mvw
