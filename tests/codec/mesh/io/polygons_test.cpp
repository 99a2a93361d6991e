#include "codec/mesh/io/polygons.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mvw {
namespace {

std::vector<Face> cut(const std::vector<Vec3>& polygon, std::uint64_t budget = 1'000'000) {
    std::vector<std::uint32_t> corners(polygon.size());
    std::iota(corners.begin(), corners.end(), 0u);
    std::vector<Face> faces;
    triangulate(polygon, corners.data(), corners.size(), faces, budget);
    return faces;
}

/// Sum of the triangles' areas, each counted negative where it faces away from `normal`.
double area_along(const std::vector<Vec3>& p, const std::vector<Face>& faces, const Vec3& normal, bool absolute) {
    double sum = 0;
    for (const Face& f : faces) {
        const double area = dot(cross(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]]), normal) / 2;
        sum += absolute ? std::abs(area) : area;
    }
    return sum;
}

/// A star of 2n corners in a tilted plane, starting anywhere.
std::vector<Vec3> star(int n, int start) {
    std::vector<Vec3> polygon;
    for (int i = start; i < 2 * n + start; ++i) {
        const double a = i * 3.14159265358979 / n, r = i % 2 == 0 ? 1 : 0.2;
        polygon.push_back({r * std::cos(a), r * std::sin(a), r * std::cos(a)});
    }
    return polygon;
}

TEST(Triangulate, ConcavePolygonsAreCoveredOnce) {
    const Vec3 normal = normalized(Vec3{-1, 0, 1});
    for (const int n : {2, 3, 5, 12, 100})
        for (const int start : {0, 1, 2, 3}) {
            const std::vector<Vec3> polygon = star(n, start);
            const std::vector<Face> faces = cut(polygon);
            ASSERT_EQ(faces.size(), polygon.size() - 2);
            const double area = area_along(polygon, faces, normal, false);
            EXPECT_GT(area, 0);
            EXPECT_NEAR(area_along(polygon, faces, normal, true), area, 1e-12) << n << " points from " << start;
        }
}

/// An n-gon with a hole, to which one edge leads and back, starting anywhere.
std::vector<Vec3> ring(int n, int start) {
    std::vector<Vec3> polygon;
    const auto add = [&](int i, double r) {
        const double a = (i % n) * 6.28318530717958 / n;
        polygon.push_back({r * std::cos(a), r * std::sin(a), 0});
    };
    for (int i = 0; i <= n; ++i) add(i, 1);
    for (int i = n; i >= 0; --i) add(i, 0.9);
    std::rotate(polygon.begin(), polygon.begin() + start, polygon.end());
    return polygon;
}

TEST(Triangulate, HolesThatAnEdgeLeadsToStayOpen) {
    for (const int n : {3, 4, 7, 32})
        for (int start = 0; start < 2 * n + 2; ++start) {
            const std::vector<Vec3> polygon = ring(n, start);
            const double area = n * std::sin(6.28318530717958 / n) / 2 * (1 - 0.81);
            const std::vector<Face> faces = cut(polygon);
            EXPECT_NEAR(area_along(polygon, faces, {0, 0, 1}, true), area, 1e-9) << n << " corners from " << start;
            EXPECT_NEAR(area_along(polygon, faces, {0, 0, 1}, false), area, 1e-9);
        }
    // Two holes that touch: one corner three times.
    const std::vector<Vec3> two{{0, 0, 0}, {6, 0, 0}, {6, 4, 0}, {3, 4, 0}, {3, 2, 0}, {5, 2, 0}, {5, 1, 0},
                                {3, 2, 0}, {1, 1, 0}, {1, 2, 0}, {3, 2, 0}, {3, 4, 0}, {0, 4, 0}};
    for (std::size_t start = 0; start < two.size(); ++start) {
        std::vector<Vec3> turned = two;
        std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(start), turned.end());
        EXPECT_NEAR(area_along(turned, cut(turned), {0, 0, 1}, true), 22, 1e-9) << start;
    }
}

TEST(Triangulate, ArrowheadsAreCutAtTheirNotch) {
    const std::vector<Vec3> arrow{{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5, 1, 0}};
    for (std::size_t start = 0; start < 4; ++start) {
        std::vector<Vec3> turned = arrow;
        std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(start), turned.end());
        const std::vector<Face> faces = cut(turned);
        EXPECT_NEAR(area_along(turned, faces, {0, 0, 1}, true), 1.5, 1e-12) << start;
    }
}

TEST(Triangulate, ConvexQuadsTakeTheShorterDiagonal) {
    EXPECT_EQ(cut({{0, 0, 0}, {3, 0, 0}, {4, 1, 0}, {1, 1, 0}}), (std::vector<Face>{{1, 2, 3}, {1, 3, 0}}));
    EXPECT_EQ(cut({{0, 0, 0}, {3, 0, 0}, {2, 1, 0}, {-1, 1, 0}}), (std::vector<Face>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Triangulate, EverySideIsUsedOnceWhateverThePolygon) {
    const std::vector<std::vector<Vec3>> odd{
        {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 2, 0}},           // crosses itself
        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},             // flat
        {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}},             // a point
        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}},  // corners along straight sides
    };
    for (const auto& polygon : odd)
        for (const std::uint64_t budget : {0, 3, 1000}) {
            const std::vector<Face> faces = cut(polygon, budget);
            const std::size_t n = polygon.size();
            ASSERT_EQ(faces.size(), n - 2);
            for (std::uint32_t side = 0; side < n; ++side) {
                int uses = 0;
                for (const Face& f : faces)
                    for (std::size_t k = 0; k < 3; ++k) uses += f[k] == side && f[(k + 1) % 3] == (side + 1) % n;
                EXPECT_EQ(uses, 1) << side;
            }
        }
}

}  // namespace
}  // namespace mvw
