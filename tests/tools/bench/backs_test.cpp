#include "tools/bench/backs.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace mvw::bench {
namespace {

TEST(Backs, AreCountedWhereTheyAreSeen) {
    Mesh mesh = icosphere(2);
    mesh.colors.assign(mesh.positions.size(), {200, 10, 10, 255});  // red paint is not a back
    auto count = count_backs(mesh);
    ASSERT_TRUE(count.ok()) << count.error().message;
    EXPECT_EQ(count->in_place, 0u);
    EXPECT_EQ(count->seen, 0u);
    std::swap(mesh.faces[0][0], mesh.faces[0][1]);
    count = count_backs(mesh);
    ASSERT_TRUE(count.ok()) << count.error().message;
    EXPECT_GT(count->in_place, 100u);
    EXPECT_GT(count->seen, 100u);
}

TEST(Backs, OfFoldsOnSolidsAreCountedButNotSeen) {
    Mesh mesh = icosphere(1);
    mesh.positions[0] = mesh.positions[0] * -1.5;  // out through the other side
    const auto count = count_backs(mesh);
    ASSERT_TRUE(count.ok()) << count.error().message;
    EXPECT_GT(count->in_place, 100u);
    EXPECT_EQ(count->seen, 0u);
}

}  // namespace
}  // namespace mvw::bench
