#include "codec/mesh/solid.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace mvw {
namespace {

Mesh turned(Mesh mesh) {
    for (Face& f : mesh.faces) std::swap(f[0], f[1]);
    return mesh;
}

Mesh both(Mesh a, const Mesh& b) {
    const auto first = static_cast<std::uint32_t>(a.positions.size());
    a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
    for (const Face& f : b.faces) a.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    return a;
}

TEST(BoundsSolids, ClosedSurfacesThatFaceOutwards) {
    EXPECT_TRUE(bounds_solids(unit_cube()));
    EXPECT_TRUE(bounds_solids(torus(12, 8)));
    EXPECT_TRUE(bounds_solids(both(unit_cube(), moved(icosphere(1), {5, 0, 0}))));
    EXPECT_TRUE(bounds_solids(moved(scaled(icosphere(2), 1e-3), {1e6, -1e6, 1e6})));
}

TEST(BoundsSolids, NotOpenOnesNorAnyThatFacesInwards) {
    EXPECT_FALSE(bounds_solids(unit_square()));
    EXPECT_FALSE(bounds_solids(Mesh{}));
    EXPECT_FALSE(bounds_solids(turned(unit_cube())));
    EXPECT_FALSE(bounds_solids(both(scaled(icosphere(1), 10), turned(moved(unit_cube(), {50, 0, 0})))));
    Mesh open = icosphere(1);
    open.faces.pop_back();
    EXPECT_FALSE(bounds_solids(open));
}

TEST(BoundsSolids, NotWhatIsNoManifold) {
    Mesh mesh = unit_cube();
    mesh.faces.push_back(mesh.faces[0]);
    EXPECT_FALSE(bounds_solids(mesh));
}

TEST(BoundsSolids, VerticesOfNoFaceDoNotMatter) {
    Mesh mesh = unit_cube();
    mesh.positions.push_back({9, 9, 9});
    EXPECT_TRUE(bounds_solids(mesh));
}

}  // namespace
}  // namespace mvw
