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
    EXPECT_EQ(*count, 0u);
    std::swap(mesh.faces[0][0], mesh.faces[0][1]);
    count = count_backs(mesh);
    ASSERT_TRUE(count.ok()) << count.error().message;
    EXPECT_GT(*count, 100u);
}

}  // namespace
}  // namespace mvw::bench
