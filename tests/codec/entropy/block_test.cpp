#include "codec/entropy/block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
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

/// A point of a face's grid, or the way from one to another.
struct Grid {
    int i = 0, k = 0;
    friend Grid operator+(Grid a, Grid b) { return {a.i + b.i, a.k + b.k}; }
    friend Grid operator-(Grid a, Grid b) { return {a.i - b.i, a.k - b.k}; }
};

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

/// Relations by the words of block.h and the numbers of all vertices, one at a time.
class SlowShape {
 public:
    SlowShape(const BaseMesh& base, const Tiling& tiling, std::uint32_t tile, unsigned level)
        : base_(base), level_(level), n_(1 << level) {
        number(block_indices(base, tiling.tiles[tile], level), places_);
        if (level > 1) number(block_indices(base, tiling.tiles[tile], level - 1), coarse_);
    }
    [[nodiscard]] std::uint32_t none() const { return static_cast<std::uint32_t>(places_.size()); }

    void expect_at(std::uint32_t place, const BlockShape& shape, std::uint32_t face, Grid p) const {
        const auto [d, a, b] = directions(p);
        const BlockShape::Neighbors near{
            at(face, p - a),     at(face, p + a),     at(face, p - b),     at(face, p + b),     at(face, p - d - d),
            at(face, p + d + d), at(face, p - a - a), at(face, p + a + a), at(face, p - b - b), at(face, p + b + b)};
        EXPECT_EQ(shape.neighbors()[place], near);
        expect_parents(place, shape, face, p);
    }
    void expect_on_edge(std::uint32_t place, const BlockShape& shape, const BaseEdge& edge, int t) const {
        std::vector<std::uint32_t> near, far;
        for (unsigned s = 0; s < 2 && edge.face[s] != kNone; ++s) {
            const Grid p = on_side(edge.side[s], s == 0 ? t : n_ - t);
            const auto [d, a, b] = directions(p);
            for (const Grid q : {Grid{} - a, a, Grid{} - b, b})
                if (has(p + q)) near.push_back(at(edge.face[s], p + q)), far.push_back(at(edge.face[s], p + q + q));
        }
        near.resize(4, none()), far.resize(4, none());
        near.push_back(at(edge.face[0], on_side(edge.side[0], t - 2)));
        near.push_back(at(edge.face[0], on_side(edge.side[0], t + 2)));
        near.insert(near.end(), far.begin(), far.end());
        const auto& got = shape.neighbors()[place];
        EXPECT_EQ(std::vector<std::uint32_t>(got.begin(), got.end()), near);
        expect_parents(place, shape, edge.face[0], on_side(edge.side[0], t));
    }

 private:
    struct Directions {
        Grid along, one, other;
    };
    static Directions directions(Grid p) {
        const Grid x{1, 0}, y{0, 1}, z{1, -1};
        if (p.k % 2 == 0) return {x, y, z};
        return p.i % 2 == 0 ? Directions{y, x, z} : Directions{z, x, y};
    }
    static void number(const std::vector<std::uint32_t>& vertices, std::map<std::uint32_t, std::uint32_t>& places) {
        for (const std::uint32_t v : vertices) places.emplace(v, static_cast<std::uint32_t>(places.size()));
    }
    [[nodiscard]] bool has(Grid p) const { return p.i >= 0 && p.k >= 0 && p.i + p.k <= n_; }
    [[nodiscard]] Grid on_side(unsigned side, int t) const {
        return side == 0 ? Grid{t, 0} : side == 1 ? Grid{n_ - t, t} : Grid{0, n_ - t};
    }
    [[nodiscard]] std::uint32_t look_up(const std::map<std::uint32_t, std::uint32_t>& places, std::uint32_t face,
                                        Grid p) const {
        if (!has(p)) return static_cast<std::uint32_t>(places.size());
        const auto found = places.find(
            vertex_index(base_, face, level_, static_cast<std::uint32_t>(p.i), static_cast<std::uint32_t>(p.k)));
        return found == places.end() ? static_cast<std::uint32_t>(places.size()) : found->second;
    }
    [[nodiscard]] std::uint32_t at(std::uint32_t face, Grid p) const { return look_up(places_, face, p); }
    void expect_parents(std::uint32_t place, const BlockShape& shape, std::uint32_t face, Grid p) const {
        if (level_ < 2) {
            EXPECT_TRUE(shape.parents().empty());
            return;
        }
        const Grid d = directions(p).along;
        const BlockShape::Parents ends{look_up(coarse_, face, p - d), look_up(coarse_, face, p + d)};
        EXPECT_EQ(shape.parents()[place], ends);
    }

    const BaseMesh& base_;
    const unsigned level_;
    const int n_;
    std::map<std::uint32_t, std::uint32_t> places_, coarse_;  // of this block's vertices, of those one level below
};

TEST(BlockShape, RelationsOfAnyTilesAreThoseFoundOneAtATime) {
    const BaseMesh closed = octahedron(), open = two_triangles();
    const std::pair<const BaseMesh*, std::vector<std::uint16_t>> cases[]{{&closed, {0, 0, 0, 0, 0, 0, 0, 0}},
                                                                         {&closed, {0, 1, 1, 0, 2, 2, 2, 0}},
                                                                         {&closed, {3, 1, 0, 2, 2, 0, 1, 3}},
                                                                         {&open, {0, 0}},
                                                                         {&open, {1, 0}}};
    for (const auto& [base, tiles] : cases) {
        const Tiling tiling(*base, tiles, std::uint32_t{*std::max_element(tiles.begin(), tiles.end())} + 1);
        for (std::uint32_t tile = 0; tile < tiling.tiles.size(); ++tile)
            for (const unsigned level : {1u, 2u, 3u, 5u}) {
                const BlockShape shape(*base, tiling, tile, level);
                const SlowShape slow(*base, tiling, tile, level);
                ASSERT_EQ(shape.size(), slow.none());
                std::uint32_t place = 0;
                const int n = 1 << level;
                for (const std::uint32_t e : tiling.tiles[tile].edges)
                    for (int t = 1; t < n; t += 2) slow.expect_on_edge(place++, shape, base->edges()[e], t);
                for (const std::uint32_t f : tiling.tiles[tile].faces)
                    for (int i = 1; i < n; ++i)
                        for (int k = 1; i + k < n; ++k)
                            if (i % 2 == 1 || k % 2 == 1) slow.expect_at(place++, shape, f, {i, k});
                EXPECT_EQ(place, shape.size());
            }
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
