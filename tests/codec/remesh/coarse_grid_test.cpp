#include "codec/remesh/coarse_grid.h"

#include <gtest/gtest.h>

#include "tests/support/semi_regular_models.h"

namespace mvw {
namespace {

/// Points all over two base faces: corners, sides, points of grids and between them.
std::vector<FacePoint> points_of_faces() {
    std::vector<FacePoint> out;
    for (const std::uint32_t face : {0u, 5u})
        for (int i = 0; i <= 24; ++i)
            for (int k = 0; i + k <= 24; ++k) out.push_back({face, {(24 - i - k) / 24.0, i / 24.0, k / 24.0}});
    return out;
}

TEST(CoarseGrid, APointOfALevelIsThatOfTheBase) {
    const SemiRegularMesh ball = bumpy_ball(4);
    for (unsigned level = 0; level <= 4; ++level) {
        const std::vector<Face> triangles = triangles_at_level(ball.base, level);
        // Each vertex' place on face 0 or 5, as that face has it.
        const std::uint32_t n = 1u << level;
        for (const FacePoint& p : points_of_faces()) {
            const FacePoint q = on_level(p, level);
            ASSERT_LT(q.face, triangles.size());
            std::vector<std::uint32_t> patch;
            patch_vertices(ball.base, p.face, level, patch);
            double x = 0, y = 0;
            for (unsigned c = 0; c < 3; ++c) {
                EXPECT_GE(q.weight[c], -1e-12);
                std::size_t at = 0;
                for (unsigned i = 0; i <= n; ++i)
                    for (unsigned k = 0; i + k <= n; ++k, ++at)
                        if (patch[at] == triangles[q.face][c]) x += q.weight[c] * i / n, y += q.weight[c] * k / n;
            }
            EXPECT_NEAR(x, p.weight[1], 1e-12);
            EXPECT_NEAR(y, p.weight[2], 1e-12);
            const FacePoint back = on_base(q, level);
            EXPECT_EQ(back.face, p.face);
            for (unsigned c = 0; c < 3; ++c) EXPECT_NEAR(back.weight[c], p.weight[c], 1e-12);
        }
    }
}

TEST(CoarseGrid, ValuesStayAtTheirVerticesAndAreMeansHalfWay) {
    const SemiRegularMesh ball = bumpy_ball(3);
    const std::vector<Vec3> coarse(ball.positions.begin(),
                                   ball.positions.begin() + std::ptrdiff_t(vertices_at_level(ball.base, 1)));
    const std::vector<Vec3> fine = interpolate(ball.base, 1, coarse, 3);
    ASSERT_EQ(fine.size(), ball.positions.size());
    for (std::size_t v = 0; v < coarse.size(); ++v) EXPECT_LT(length(fine[v] - coarse[v]), 1e-12);
    for (const BaseEdge& e : ball.base.edges()) {
        const auto at = [&](unsigned t) { return fine[edge_vertex_index(ball.base, e, 3, t)]; };
        EXPECT_LT(length(at(2) - (at(0) + at(4)) * 0.5), 1e-12);
        EXPECT_LT(length(at(7) - (at(4) + at(8) * 3.0) * 0.25), 1e-12);
    }
}

}  // namespace
}  // namespace mvw
