#include "codec/mesh/semi_regular.h"

#include <gtest/gtest.h>

#include <set>

namespace mvw {
namespace {

BaseMesh tetrahedron() {
    return BaseMesh::create(4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}).value();
}

TEST(SemiRegular, EveryLevelNumbersItsVerticesOnceAndKeepsThoseBelow) {
    const BaseMesh base = tetrahedron();
    for (unsigned level = 0; level <= 5; ++level) {
        std::set<std::uint32_t> seen;
        std::vector<std::uint32_t> patch;
        for (std::uint32_t f = 0; f < base.face_count(); ++f) {
            patch_vertices(base, f, level, patch);
            const std::uint32_t n = 1u << level;
            for (std::uint32_t i = 0; i <= n; ++i)
                for (std::uint32_t k = 0; i + k <= n; ++k)
                    ASSERT_EQ(patch[patch_place(n, i, k)], vertex_index(base, f, level, i, k)) << level;
            seen.insert(patch.begin(), patch.end());
        }
        EXPECT_EQ(seen.size(), vertices_at_level(base, level));
        EXPECT_EQ(*seen.rbegin() + 1, vertices_at_level(base, level));
    }
    EXPECT_EQ(vertex_index(base, 2, 4, 4, 8), vertex_index(base, 2, 2, 1, 2));
}

TEST(SemiRegular, EveryLevelIsClosedAndOriented) {
    const BaseMesh base = tetrahedron();
    for (unsigned level = 0; level <= 4; ++level) {
        std::vector<Face> faces = triangles_at_level(base, level);
        ASSERT_EQ(faces.size(), std::size_t{4} << (2 * level));
        const auto V = static_cast<std::uint32_t>(vertices_at_level(base, level));
        const auto fine = BaseMesh::create(V, std::move(faces));
        ASSERT_TRUE(fine.ok());
        for (const BaseEdge& e : fine->edges()) EXPECT_NE(e.face[1], kNone);
        EXPECT_EQ(V + fine->face_count() - fine->edge_count(), 2u);
    }
}

TEST(SemiRegular, InteriorRankCountsARunWithoutGaps) {
    for (unsigned level = 2; level <= 6; ++level) {
        const std::uint32_t n = 1u << level;
        std::uint32_t expected = 0;
        for (std::uint32_t i = 1; i < n; ++i)
            for (std::uint32_t k = 1; i + k < n; ++k) {
                if (i % 2 == 0 && k % 2 == 0) continue;
                EXPECT_EQ(interior_rank(level, i, k), expected++);
            }
        EXPECT_EQ(expected, interior_points(level) - interior_points(level - 1));
    }
}

TEST(BaseMesh, RefusesNonManifoldAndMisorientedFaces) {
    EXPECT_FALSE(BaseMesh::create(3, {{0, 1, 3}}).ok());
    EXPECT_FALSE(BaseMesh::create(3, {{0, 1, 1}}).ok());
    EXPECT_FALSE(BaseMesh::create(4, {{0, 1, 2}, {0, 1, 3}}).ok());
    EXPECT_FALSE(BaseMesh::create(5, {{0, 1, 2}, {1, 0, 3}, {1, 0, 4}}).ok());
}

}  // namespace
}  // namespace mvw
