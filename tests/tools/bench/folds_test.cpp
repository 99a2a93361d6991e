#include "tools/bench/folds.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"
#include "tests/support/shapes.h"

namespace mvw::bench {
namespace {

TEST(Folds, AreCountedWhereTrianglesTurnBack) {
    EXPECT_EQ(count_folds(icosphere(3)), 0u);
    EXPECT_EQ(count_folds(unit_cube()), 0u);
    Mesh folded = unit_square();
    folded.positions[3] = {0.9, 0.2, 0.01};  // the second triangle laid back over the first
    EXPECT_EQ(count_folds(folded), 1u);
}

TEST(Topology, SumsOverTheComponents) {
    const Topology both = topology_of(join(torus(12, 8), icosphere(1)));
    EXPECT_EQ(both, (Topology{.components = 2, .boundary_loops = 0, .genus = 1}));
    EXPECT_EQ(topology_of(grid_mesh(3)), (Topology{.components = 1, .boundary_loops = 1, .genus = 0}));
}

}  // namespace
}  // namespace mvw::bench
