#include "codec/remesh/relax.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "codec/remesh/unfold.h"
#include "tests/support/meshes.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

Vec3 scaled_normal(const std::vector<Vec3>& p, const Face& f) {
    return cross(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]]);
}

/// A mesh whose own vertices are the points, some of them pushed over the surface until triangles turn over.
struct Tangle {
    explicit Tangle(Mesh shape, double push) : mesh(std::move(shape)), surface(mesh, {}) {
        points.resize(mesh.positions.size());
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                points[mesh.faces[f][k]] = {f, {}};
                points[mesh.faces[f][k]].weight[k] = 1;
            }
        fixed.assign(points.size(), 0);
        std::vector<std::uint32_t> uses(points.size(), 0);
        for (const Face& f : mesh.faces)
            for (const std::uint32_t v : f) ++uses[v];
        for (std::size_t v = 0; v < points.size(); ++v) fixed[v] = uses[v] < 5 ? 1 : 0;  // the rim of a square
        std::mt19937 random(5);
        std::uniform_real_distribution<double> way(-push, push);
        for (std::size_t v = 0; v < points.size(); ++v)
            if (fixed[v] == 0) points[v] = surface.walk(points[v], {way(random), way(random), way(random)});
    }
    [[nodiscard]] std::vector<Vec3> positions() const {
        std::vector<Vec3> out;
        for (const FacePoint& p : points) out.push_back(surface.position(p));
        return out;
    }
    /// Triangles that look away from the surface.
    [[nodiscard]] std::size_t turned() const {
        const std::vector<Vec3> p = positions();
        std::size_t count = 0;
        for (const Face& f : mesh.faces)
            if (dot(scaled_normal(p, f), surface.normal(points[f[0]])) <= 0) ++count;
        return count;
    }
    Mesh mesh;
    SurfaceWalk surface;
    std::vector<FacePoint> points;
    std::vector<std::uint8_t> fixed;
};

TEST(Relax, TurnsFoldedTrianglesBack) {
    const double edge = length(grid_mesh(16).positions[1] - grid_mesh(16).positions[0]);
    Tangle square(grid_mesh(16), 0.9 * edge), sphere(icosphere(3), 0.15);
    for (Tangle* tangle : {&square, &sphere}) {
        ASSERT_GT(tangle->turned(), 10u);
        RelaxOptions options;
        options.sweeps = 60;
        relax(tangle->surface, tangle->mesh.faces, tangle->fixed, options, tangle->points);
        EXPECT_EQ(tangle->turned(), 0u);
    }
}

TEST(Relax, KeepsTheTipsOfThinPartsCovered) {
    Mesh spindle = icosphere(4);
    for (Vec3& p : spindle.positions) p.z *= 12 * (1 + 0.5 * p.z * p.z);
    Tangle tangle(spindle, 0.1);
    RelaxOptions options;
    options.sweeps = 60;
    relax(tangle.surface, tangle.mesh.faces, tangle.fixed, options, tangle.points);
    const auto height = [](const std::vector<Vec3>& points) {
        double most = 0;
        for (const Vec3& p : points) most = std::max(most, p.z);
        return most;
    };
    EXPECT_GT(height(tangle.positions()), 0.97 * height(spindle.positions));
}

TEST(Relax, LeavesWhatIsFixed) {
    Tangle tangle(grid_mesh(16), 0.05);
    const std::vector<Vec3> before = tangle.positions();
    relax(tangle.surface, tangle.mesh.faces, tangle.fixed, {}, tangle.points);
    const std::vector<Vec3> after = tangle.positions();
    for (std::size_t v = 0; v < before.size(); ++v) EXPECT_TRUE(tangle.fixed[v] == 0 || after[v] == before[v]);
}

TEST(Relax, GivesTheSameForAnyNumberOfThreads) {
    Tangle one(icosphere(4), 0.08), three(icosphere(4), 0.08);
    relax(one.surface, one.mesh.faces, one.fixed, {10, 1}, one.points);
    relax(three.surface, three.mesh.faces, three.fixed, {10, 3}, three.points);
    EXPECT_EQ(one.positions(), three.positions());
}

TEST(Unfold, SmoothsAVertexThatIsPulledThroughItsRing) {
    Mesh mesh = grid_mesh(8);
    const std::vector<std::uint8_t> fixed(mesh.positions.size(), 0);
    std::size_t middle = 0;  // the vertex nearest to the middle, where no boundary is near
    const Vec3 center = bounding_box(mesh).center();
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        if (length(mesh.positions[v] - center) < length(mesh.positions[middle] - center)) middle = v;
    const std::vector<Vec3> flat = mesh.positions;
    mesh.positions[middle] += (mesh.positions[1] - mesh.positions[0]) * 1.6;
    const auto turned = [&] {
        return std::count_if(mesh.faces.begin(), mesh.faces.end(),
                             [&](const Face& f) { return scaled_normal(mesh.positions, f).z <= 0; });
    };
    ASSERT_GT(turned(), 0);
    unfold(mesh.faces, std::vector<Vec3>(fixed.size(), {0, 0, 1}), fixed, mesh.positions);
    EXPECT_EQ(turned(), 0);
}

TEST(Unfold, LeavesSmoothSurfacesAndFixedVerticesAlone) {
    Mesh sphere = icosphere(3);
    const std::vector<Vec3> before = sphere.positions;
    unfold(sphere.faces, before, std::vector<std::uint8_t>(before.size(), 0), sphere.positions);
    EXPECT_EQ(sphere.positions, before);
    Mesh spiked = sphere;
    spiked.positions[20] = spiked.positions[20] * -3.0;
    const std::vector<Vec3> pulled = spiked.positions;
    unfold(spiked.faces, before, std::vector<std::uint8_t>(before.size(), 1), spiked.positions);
    EXPECT_EQ(spiked.positions, pulled);
}

}  // namespace
}  // namespace mvw
