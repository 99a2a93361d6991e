#include "codec/remesh/line_spacing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "codec/remesh/resample.h"

namespace mvw {
namespace {

/// A flat strip of unit diagonal, one long side of which ends in a quarter of a small circle; the base is two faces.
struct Strip {
    Mesh mesh;
    std::unique_ptr<SelfParameterization> parameterization;
    SemiRegularMesh part;
    std::vector<std::uint32_t> face_ids;

    explicit Strip(double radius) {
        constexpr int kPoints = 40;
        for (int i = 0; i <= kPoints; ++i) {  // along x, then round the corner
            const double turn = std::max(0, i - kPoints / 2) * std::numbers::pi / kPoints;
            const int until = radius > 0 ? kPoints / 2 : kPoints;  // without a corner, straight on
            const double x = std::min(i, until) * 0.8 / until + radius * std::sin(turn);
            mesh.positions.push_back({x, -radius * (1 - std::cos(turn)), 0});
            mesh.positions.push_back({x * 0.5, 0.4, 0});
        }
        for (std::uint32_t i = 0; i < 2 * kPoints; i += 2) {
            mesh.faces.push_back({i, i + 2, i + 1});
            mesh.faces.push_back({i + 1, i + 2, i + 3});
        }
        DecimateOptions options;
        options.target_faces = 2;
        options.corner_reach = 0.01;
        parameterization = std::make_unique<SelfParameterization>(mesh, std::vector<std::uint8_t>{}, options);
        const CollapseMesh& base = parameterization->base();
        std::vector<Face> faces;
        std::vector<std::uint32_t> number(mesh.positions.size(), kNone);
        std::uint32_t vertices = 0;
        for (std::uint32_t f = 0; f < base.faces.size(); ++f) {
            if (base.faces[f][0] == kNone) continue;
            Face face = base.faces[f];
            for (std::uint32_t& v : face) {
                if (number[v] == kNone) number[v] = vertices++;
                v = number[v];
            }
            faces.push_back(face);
            face_ids.push_back(f);
        }
        part.base = BaseMesh::create(vertices, std::move(faces)).value();
        part.levels = 4;
    }

    /// Largest distance of the input's vertices from the boundary of the grid, even or spaced.
    [[nodiscard]] double most_cut(bool spaced) const {
        std::vector<FacePoint> points = grid_points(part.base, part.levels, face_ids);
        if (spaced) space_lines(mesh, *parameterization, part, face_ids, 1, points);
        parameterization->to_input(points, 1);
        const std::vector<Vec3> positions = positions_of(mesh, points);
        double most = 0;
        for (const Vec3& p : mesh.positions) {
            double nearest = 1;
            for (const BaseEdge& e : part.base.edges()) {
                if (e.face[1] != kNone) continue;
                for (std::uint32_t t = 0; t < 1u << part.levels; ++t) {
                    const Vec3& a = positions[edge_vertex_index(part.base, e, part.levels, t)];
                    const Vec3 ab = positions[edge_vertex_index(part.base, e, part.levels, t + 1)] - a;
                    const double s = std::clamp(dot(p - a, ab) / squared_length(ab), 0.0, 1.0);
                    nearest = std::min(nearest, length(a + ab * s - p));
                }
            }
            most = std::max(most, nearest);
        }
        return most;
    }
};

TEST(LineSpacing, FollowsABendThatEvenStepsCutOff) {
    const Strip strip(0.03);
    EXPECT_GT(strip.most_cut(false), 1e-3);
    EXPECT_LT(strip.most_cut(true), 0.5 * strip.most_cut(false));
}

TEST(LineSpacing, LeavesEvenStepsWhereTheyCutNothing) {
    const Strip strip(0);
    std::vector<FacePoint> points = grid_points(strip.part.base, strip.part.levels, strip.face_ids);
    const std::vector<FacePoint> before = points;
    space_lines(strip.mesh, *strip.parameterization, strip.part, strip.face_ids, 1, points);
    for (std::size_t v = 0; v < points.size(); ++v) {
        EXPECT_EQ(points[v].face, before[v].face) << v;
        EXPECT_EQ(points[v].weight, before[v].weight) << v;
    }
}

}  // namespace
}  // namespace mvw
