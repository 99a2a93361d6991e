#include "codec/entropy/block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

namespace mvw {
namespace {

BaseMesh octahedron() {
    return BaseMesh::create(6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}})
        .value();
}

BaseMesh two_triangles() {
    return BaseMesh::create(4, {{0, 1, 2}, {2, 1, 3}}).value();
}

TEST(Tiling, GivesEveryVertexEdgeAndFaceToOneTile) {
    const BaseMesh base = octahedron();
    const Tiling tiling(base, std::vector<std::uint16_t>{0, 1, 1, 0, 2, 2, 2, 0}, 3);
    EXPECT_EQ(tiling.tiles[0].vertices, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(tiling.tiles[1].vertices, (std::vector<std::uint32_t>{3, 4}));
    EXPECT_EQ(tiling.tiles[2].vertices, (std::vector<std::uint32_t>{5}));
    std::size_t edges = 0, faces = 0;
    for (const Tiling::Tile& tile : tiling.tiles) edges += tile.edges.size(), faces += tile.faces.size();
    EXPECT_EQ(edges, base.edge_count());
    EXPECT_EQ(faces, base.face_count());
    for (std::uint32_t e = 0; e < base.edge_count(); ++e)
        EXPECT_EQ(tiling.tiles[tiling.edge[e].tile].edges[tiling.edge[e].slot], e);
}

TEST(BlockShape, BlocksOfAllTilesAndLevelsNameEveryVertexOnce) {
    const BaseMesh base = octahedron();
    const Tiling tiling(base, std::vector<std::uint16_t>{0, 1, 1, 0, 2, 2, 2, 0}, 3);
    std::set<std::uint32_t> seen;
    std::size_t total = 0;
    for (unsigned level = 0; level <= 5; ++level) {
        for (std::uint32_t t = 0; t < 3; ++t) {
            const BlockShape shape(base, tiling, t, level);
            EXPECT_EQ(shape.size(), block_size(tiling.tiles[t], level));
            EXPECT_TRUE(std::is_sorted(shape.indices().begin(), shape.indices().end()));
            seen.insert(shape.indices().begin(), shape.indices().end());
            total += shape.size();
        }
        EXPECT_EQ(total, vertices_at_level(base, level));
        EXPECT_EQ(seen.size(), total);
        EXPECT_EQ(*seen.rbegin() + 1, total);
    }
}

TEST(BlockShape, NeighborsAreMutualAndNearInTheGrid) {
    const BaseMesh base = octahedron();
    const Tiling tiling(base, std::vector<std::uint16_t>(8, 0), 1);
    for (const unsigned level : {1u, 2u, 4u}) {
        const BlockShape shape(base, tiling, 0, level);
        const auto& near = shape.neighbors();
        std::size_t links = 0;
        for (std::uint32_t i = 0; i < shape.size(); ++i) {
            for (const std::uint32_t k : near[i]) {
                if (k == shape.size()) continue;
                ASSERT_LT(k, shape.size());
                EXPECT_NE(k, i);
                EXPECT_NE(std::find(near[k].begin(), near[k].end(), i), near[k].end()) << i << " and " << k;
                ++links;
            }
            // On a closed surface in one tile the four sides of the two triangles are always there.
            EXPECT_EQ(std::count(near[i].begin(), near[i].begin() + 4, shape.size()), 0);
        }
        EXPECT_GE(links, shape.size() * 4);
    }
}

TEST(BlockShape, RelationsNeverCrossTilesOrTheBoundary) {
    const BaseMesh base = two_triangles();
    const Tiling one(base, std::vector<std::uint16_t>{0, 0}, 1), two(base, std::vector<std::uint16_t>{0, 1}, 2);
    const BlockShape whole(base, one, 0, 2), first(base, two, 0, 2), second(base, two, 1, 2);
    EXPECT_EQ(whole.size(), first.size() + second.size());
    const auto links = [](const BlockShape& shape) {
        std::size_t n = 0;
        for (const auto& near : shape.neighbors()) {
            n += BlockShape::kNeighbors - static_cast<std::size_t>(std::count(near.begin(), near.end(), shape.size()));
            for (const std::uint32_t k : near) EXPECT_LE(k, shape.size());
        }
        return n;
    };
    EXPECT_LT(links(first) + links(second), links(whole));
}

TEST(BlockShape, ParentsAreTheEndsOfThePointsEdgeThatWereNewOneLevelBelow) {
    const BaseMesh base = octahedron();
    const Tiling tiling(base, std::vector<std::uint16_t>(8, 0), 1);
    const BlockShape coarse(base, tiling, 0, 3), fine(base, tiling, 0, 4);
    const unsigned n = 16;
    std::vector<std::uint32_t> place(vertices_at_level(base, 4), kNone);
    for (std::uint32_t i = 0; i < fine.size(); ++i) place[fine.indices()[i]] = i;
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        for (unsigned i = 1; i < n; i += 2)
            for (unsigned k = 2; i + k < n; k += 2) {
                std::multiset<std::uint32_t> expected, got;
                for (const unsigned end : {i - 1, i + 1}) {
                    const std::uint32_t v = vertex_index(base, f, 4, end, k);
                    const auto at = std::lower_bound(coarse.indices().begin(), coarse.indices().end(), v);
                    if (at != coarse.indices().end() && *at == v)
                        expected.insert(static_cast<std::uint32_t>(at - coarse.indices().begin()));
                }
                for (const std::uint32_t p : fine.parents()[place[vertex_index(base, f, 4, i, k)]])
                    if (p != coarse.size()) got.insert(p);
                EXPECT_EQ(got, expected);
                EXPECT_FALSE(got.empty());
            }
}

TEST(BlockShape, LevelZeroJoinsBaseVerticesByEdges) {
    const BaseMesh base = octahedron();
    const Tiling tiling(base, std::vector<std::uint16_t>(8, 0), 1);
    const BlockShape shape(base, tiling, 0, 0);
    ASSERT_EQ(shape.size(), 6u);
    EXPECT_TRUE(shape.parents().empty());
    EXPECT_EQ(std::count(shape.neighbors()[0].begin(), shape.neighbors()[0].end(), 6u), BlockShape::kNeighbors - 4);
}

}  // namespace
}  // namespace mvw
