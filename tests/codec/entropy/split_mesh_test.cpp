#include "codec/entropy/split_mesh.h"

#include <gtest/gtest.h>

#include <random>

#include "codec/mesh/semi_regular.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

BaseMesh base_of(const Mesh& mesh) {
    return BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces).value();
}
BaseMesh base_of(const SplitMesh& mesh) {
    return BaseMesh::create(mesh.vertex_count(), mesh.faces()).value();
}
std::int64_t euler(const BaseMesh& mesh) {
    return std::int64_t{mesh.vertex_count()} - mesh.edge_count() + mesh.face_count();
}
std::size_t boundary_edges(const BaseMesh& mesh) {
    return 2 * std::size_t{mesh.edge_count()} - 3 * std::size_t{mesh.face_count()};
}

/// Any split that its ring allows.
Split random_split(const VertexRing& ring, std::uint32_t vertex, std::mt19937& random) {
    Split split{vertex, 0, 0, false};
    do {
        split.first = static_cast<std::uint32_t>(random() % (ring.faces + 1));
        split.taken = static_cast<std::uint32_t>(random() % (ring.faces + 1));
        split.boundary = random() % 2 != 0;
    } while (!SplitMesh::is_possible(ring, split));
    return split;
}

TEST(SplitMesh, WhateverIsSplitStaysAManifoldOfTheSameTopology) {
    for (const Mesh& start : {unit_cube(), unit_square(), torus(4, 5), icosphere(0)}) {
        SplitMesh mesh(base_of(start), std::vector<std::uint32_t>(start.faces.size(), 7));
        const BaseMesh before = base_of(start);
        std::mt19937 random(1);
        VertexRing ring;
        std::size_t boundaries = boundary_edges(before);
        for (int k = 0; k < 500; ++k) {
            const auto v = static_cast<std::uint32_t>(random() % mesh.vertex_count());
            if (!mesh.ring(v, ring)) continue;
            const Split split = random_split(ring, v, random);
            boundaries += split.boundary;
            mesh.split(ring, split, {7, 7});
            if (k % 20 != 0) continue;
            const BaseMesh now = base_of(mesh);  // or create() would have refused
            EXPECT_EQ(euler(now), euler(before));
            EXPECT_EQ(boundary_edges(now), boundaries);
            EXPECT_EQ(mesh.materials().size(), mesh.faces().size());
        }
    }
}

TEST(SplitMesh, RingsRunCounterClockwiseAndFromTheBoundary) {
    const Mesh square = unit_square();
    const SplitMesh mesh(base_of(square), {});
    for (std::uint32_t v = 0; v < 4; ++v) {
        VertexRing ring;
        ASSERT_TRUE(mesh.ring(v, ring));
        EXPECT_FALSE(ring.closed);
        EXPECT_EQ(ring.neighbors, ring.faces + 1);
        for (std::size_t m = 0; m < ring.faces; ++m) {
            const Vec3 a = square.positions[ring.neighbor[m]] - square.positions[v];
            const Vec3 b = square.positions[ring.neighbor[m + 1]] - square.positions[v];
            EXPECT_GT(cross(a, b).z, 0);
        }
    }
}

TEST(SplitMesh, TheNewVertexTakesOverTheFacesThatItIsTold) {
    SplitMesh mesh(base_of(icosphere(0)), {});
    VertexRing ring;
    ASSERT_TRUE(mesh.ring(3, ring));
    ASSERT_EQ(ring.faces, 5u);
    mesh.split(ring, {3, 1, 2, false}, {0, 0});
    VertexRing kept, made;
    ASSERT_TRUE(mesh.ring(3, kept) && mesh.ring(12, made));
    EXPECT_EQ(kept.faces, 5u);  // three of its own and two between
    EXPECT_EQ(made.faces, 4u);  // two and two
    const auto is_beside = [](const VertexRing& r, std::uint32_t v) {
        return std::find(r.neighbor.begin(), r.neighbor.begin() + std::ptrdiff_t(r.neighbors), v) !=
               r.neighbor.begin() + std::ptrdiff_t(r.neighbors);
    };
    for (const std::size_t m : {1, 2, 3}) EXPECT_TRUE(is_beside(made, ring.neighbor[m])) << m;
    for (const std::size_t m : {3, 4, 0, 1}) EXPECT_TRUE(is_beside(kept, ring.neighbor[m])) << m;
    EXPECT_FALSE(is_beside(kept, ring.neighbor[2]));
}

}  // namespace
}  // namespace mvw
