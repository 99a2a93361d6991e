// What every transform promises whatever the mesh: polynomials that it reproduces, symmetries, odd little bases.
#include <gtest/gtest.h>

#include "codec/transform/reference/reference.h"
#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

/// Vertices of a flat sheet of w x w quads in two triangles, unit edges, at the finest level; and which of them lie at
/// least `margin` base edges inside.
struct Sheet {
    BaseMesh base;
    std::vector<Vec3> points;
    std::vector<bool> inner;
};

Sheet flat_sheet(std::uint32_t w, unsigned levels, double margin) {
    Sheet sheet{test::grid(w, w, false), {}, {}};
    const auto V = vertices_at_level(sheet.base, levels);
    std::vector<Vec3> coarse(V), fine(V);
    for (std::uint32_t v = 0; v < sheet.base.vertex_count(); ++v) {
        const std::uint32_t column = v % (w + 1), row = v / (w + 1);
        coarse[v] = {double(column), double(row), 0};
    }
    ReferenceTransform(sheet.base, levels, {.kind = TransformKind::InterpLazy, .local_frames = false})
        .synthesize(coarse, levels, fine);
    for (const Vec3& p : fine) {
        sheet.points.push_back({p.x + p.y / 2, p.y * std::sqrt(0.75), 0});
        sheet.inner.push_back(std::min({p.x, p.y, w - p.x, w - p.y}) >= margin);
    }
    return sheet;
}

template <typename Height>
double largest_inner_detail(TransformKind kind, double margin, Height height) {
    const unsigned levels = 2;
    const Sheet sheet = flat_sheet(8, levels, margin);
    std::vector<Vec3> positions = sheet.points, coefficients(positions.size());
    for (Vec3& p : positions) p.z = height(p.x, p.y);
    const ReferenceTransform transform(sheet.base, levels, {.kind = kind, .local_frames = false});
    transform.analyze(positions, coefficients);
    double worst = 0;
    for (std::size_t v = vertices_at_level(sheet.base, levels - 1); v < coefficients.size(); ++v)
        if (sheet.inner[v]) worst = std::max(worst, length(coefficients[v]));
    return worst;
}

TEST(Transforms, FindNoDetailInPlanes) {
    for (unsigned k = 0; k < kTransformCount; ++k) {
        const auto kind = static_cast<TransformKind>(k);
        // Where the sheet's boundary turns a corner, only the midpoint rule stays on it.
        const double margin = predict_rule(kind) == PredictRule::Interp ? 0 : 3;
        EXPECT_LT(largest_inner_detail(kind, margin, [](double, double) { return 2.0; }), 1e-13) << k;
        EXPECT_LT(largest_inner_detail(kind, margin, [](double x, double y) { return 3 * x - 2 * y; }), 1e-12) << k;
    }
}

TEST(Transforms, SeededRuleReproducesCubics) {
    const auto cubic = [](double x, double y) { return (x * x * x - 2 * x * y * y + x * y + y * y) / 64; };
    EXPECT_LT(largest_inner_detail(TransformKind::SeededLazy, 2, cubic), 1e-13);
    EXPECT_GT(largest_inner_detail(TransformKind::InterpLazy, 2, cubic), 1e-3);
}

TEST(Transforms, ButterflyReproducesCubicsAndThePaperErrsByAQuarterOnTheSquare) {
    const auto square = [](double x, double y) { return x * x + y * y; };
    EXPECT_LT(largest_inner_detail(TransformKind::ButterflyLazy, 2, square), 1e-12);
    const double h = 0.5;  // edges of level 1
    EXPECT_NEAR(largest_inner_detail(TransformKind::InterpLazy, 2, square), h * h / 4, 1e-12);
}

TEST(Transforms, CommuteWithAffineMaps) {
    const BaseMesh base = test::grid(5, 5, true, {6, 13});
    const auto V = vertices_at_level(base, 2);
    const std::vector<Vec3> positions = test::random_positions(V);
    const auto map = [](const Vec3& p) {
        return Vec3{2 * p.x - p.y + 1, p.x + 3 * p.z - 4, p.y - p.z + 0.5 * p.x + 2};
    };
    const auto map_vector = [&](const Vec3& d) { return map(d) - map({}); };
    for (unsigned k = 0; k < static_cast<unsigned>(TransformKind::SeededNormal); ++k) {
        const ReferenceTransform transform(base, 2, {.kind = static_cast<TransformKind>(k), .local_frames = false});
        std::vector<Vec3> moved, plain(V), found(V);
        for (const Vec3& p : positions) moved.push_back(map(p));
        transform.analyze(positions, plain);
        transform.analyze(moved, found);
        for (std::size_t v = 0; v < V; ++v) {
            const Vec3 wanted = v < base.vertex_count() ? map(plain[v]) : map_vector(plain[v]);
            ASSERT_LT(length(found[v] - wanted), 1e-10) << k;
        }
    }
}

TEST(Transforms, FramesTurnWithTheSurface) {
    const BaseMesh base = test::bipyramid(5);
    const auto V = vertices_at_level(base, 3);
    const std::vector<Vec3> positions = test::random_positions(V);
    std::vector<Vec3> turned;
    turned.reserve(positions.size());
    for (const Vec3& p : positions) turned.push_back({p.y + 3, p.z - 1, p.x});
    const ReferenceTransform transform(base, 3, {});
    std::vector<Vec3> plain(V), found(V);
    transform.analyze(positions, plain);
    transform.analyze(turned, found);
    for (std::size_t v = base.vertex_count(); v < V; ++v) ASSERT_LT(length(found[v] - plain[v]), 1e-9);
}

TEST(Transforms, ReconstructOnRandomBases) {
    std::mt19937 random(5);
    for (unsigned round = 0; round < 30; ++round) {
        std::vector<Face> faces;
        const auto at = [](std::uint32_t x, std::uint32_t y) { return (y % 5) * 5 + x % 5; };
        for (std::uint32_t y = 0; y < 5; ++y)
            for (std::uint32_t x = 0; x < 5; ++x) {
                const std::uint32_t a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
                const bool other = random() % 2 == 0;
                if (random() % 6 != 0) faces.push_back(other ? Face{a, b, d} : Face{a, b, c});
                if (random() % 6 != 0) faces.push_back(other ? Face{b, c, d} : Face{a, c, d});
            }
        // Holes that touch make vertices whose triangles do not form one fan: these must survive too.
        const BaseMesh base = BaseMesh::create(25, std::move(faces)).value();
        std::vector<std::uint8_t> creases(base.edge_count());
        for (std::uint8_t& c : creases) c = random() % 8 == 0 ? 1 : 0;
        const auto kind = static_cast<TransformKind>(random() % kTransformCount);
        const auto V = vertices_at_level(base, 4);
        const std::vector<Vec3> positions = test::random_positions(V, round);
        std::vector<Vec3f> given, coefficients(V), back(V);
        for (const Vec3& p : positions) given.push_back(to_float(p));
        PatchTransform transform(base, 4, {.kind = kind, .local_frames = false}, creases);
        transform.analyze(given, coefficients);
        transform.synthesize(coefficients, 4, back);
        float largest = 1, worst = 0;
        for (std::size_t v = 0; v < V; ++v) {
            largest = std::max(largest, length(coefficients[v]));
            worst = std::max(worst, length(back[v] - given[v]));
        }
        EXPECT_LT(worst, 1e-5f * largest) << "round " << round << " " << transform_name(kind);
    }
}

TEST(Transforms, TemplateOfTheSevenVertexTorusMergesToSeven) {
    const BaseMesh base = test::seven_vertex_torus();
    const Level level = make_level(base, 0, {});
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        EXPECT_TRUE(is_ordinary(level, e));
        EXPECT_EQ(lifting_template(level, e, false).size(), 7u);
    }
}

TEST(Transforms, KleinBottleIsRefused) {
    std::vector<Face> faces;
    // A 4 x 4 grid whose rows join with a flip.
    const auto at = [](std::uint32_t x, std::uint32_t y) { return (y % 4) * 4 + (y >= 4 ? (8 - x) % 4 : x % 4); };
    for (std::uint32_t y = 0; y < 4; ++y)
        for (std::uint32_t x = 0; x < 4; ++x) {
            faces.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
            faces.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    EXPECT_FALSE(BaseMesh::create(16, std::move(faces)).ok());
}

}  // namespace
}  // namespace mvw
