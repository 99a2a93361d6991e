#include "codec/remesh/density.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace mvw {
namespace {

TEST(Density, IsTheFacesOwnAreaWhereAllAreAlike) {
    const Mesh mesh = grid_mesh(10);
    const Face& f = mesh.faces[0];
    const double area =
        0.5 * length(cross(mesh.positions[f[1]] - mesh.positions[f[0]], mesh.positions[f[2]] - mesh.positions[f[0]]));
    for (const double a : areas_around(mesh.positions, mesh.faces)) EXPECT_NEAR(a, area, 1e-12);
}

TEST(Density, ShowsWhereFacesAreSmallAndIgnoresOneThatHasNoArea) {
    Mesh mesh = grid_mesh(20);
    const double middle = bounding_box(mesh).center().x;
    for (Vec3& p : mesh.positions)
        if (p.x > middle) p.x = middle + (p.x - middle) * 0.1;
    mesh.positions[mesh.faces[0][0]] = mesh.positions[mesh.faces[0][1]];
    const std::vector<double> area = areas_around(mesh.positions, mesh.faces);
    double largest = 0, smallest = 1e300;
    for (const double a : area) largest = std::max(largest, a), smallest = std::min(smallest, a);
    EXPECT_NEAR(largest / smallest, 10, 1);
    EXPECT_GT(area[0], 0.3 * largest);
}

}  // namespace
}  // namespace mvw
