// The paper's noise experiment (its section 6) on a surface by formula, against figures computed independently.
#include <gtest/gtest.h>

#include <numbers>

#include "codec/transform/level.h"
#include "codec/transform/transform.h"
#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

constexpr unsigned kLevels = 5;

BaseMesh icosahedron() {
    return test::make_base(12, {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}});
}

/// Midpoints projected to the unit sphere, level by level, then scaled by a bumpy radius.
std::vector<Vec3f> bumpy_ball(const BaseMesh& base) {
    const double g = std::numbers::phi;
    std::vector<Vec3> points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                             {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (Vec3& p : points) p = normalized(p);
    for (unsigned j = 0; j < kLevels; ++j) {
        const Level level = make_level(base, j, {});
        points.resize(vertices_at_level(base, j + 1));
        for (const Level::Edge& e : level.edges)
            points[e.odd] = normalized(points[level.from(e.half)] + points[level.to(e.half)]);
    }
    std::vector<Vec3f> out;
    out.reserve(points.size());
    for (const Vec3& p : points)
        out.push_back(
            to_float(p * (1 + 0.2 * std::sin(5 * p.x) * std::cos(4 * p.y + 1) + 0.08 * std::sin(11 * p.z + 3 * p.x) +
                          0.02 * std::sin(31 * p.y) * std::sin(29 * p.z))));
    return out;
}

std::vector<double> errors_of(TransformKind kind) {
    const BaseMesh base = icosahedron();
    const std::vector<Vec3f> clean = bumpy_ball(base);
    std::vector<Vec3f> noisy = clean, coefficients(clean.size()), out(clean.size());
    std::mt19937 random(3);
    std::normal_distribution<float> normal(0, 0.01f);
    for (Vec3f& p : noisy) p += Vec3f{normal(random), normal(random), normal(random)};
    PatchTransform transform(base, kLevels, {.kind = kind, .local_frames = false});
    transform.analyze(noisy, coefficients);
    std::vector<double> errors;
    for (unsigned k = kLevels + 1; k-- > 0;) {
        std::fill(coefficients.begin() + std::ptrdiff_t(vertices_at_level(base, k)), coefficients.end(), Vec3f{});
        transform.synthesize(coefficients, kLevels, out);
        double sum = 0;
        for (std::size_t v = 0; v < out.size(); ++v) sum += double(squared_length(out[v] - clean[v]));
        errors.push_back(std::sqrt(sum / double(out.size())));
    }
    return errors;
}

void expect_errors(TransformKind kind, const std::vector<double>& wanted) {
    const std::vector<double> found = errors_of(kind);
    for (std::size_t i = 0; i < wanted.size(); ++i)
        EXPECT_NEAR(found[i], wanted[i], 0.1 * wanted[i]) << i << " analyses";
}

TEST(NoiseExperiment, LeavesWhatAnIndependentPrototypeFound) {
    expect_errors(TransformKind::Interp, {0.017, 0.0095, 0.011, 0.027, 0.079, 0.114});
    expect_errors(TransformKind::InterpLazy, {0.017, 0.014, 0.019, 0.040, 0.101, 0.191});
    expect_errors(TransformKind::Loop, {0.017, 0.010, 0.014, 0.024, 0.084, 0.122});
}

TEST(NoiseExperiment, LazyLoopDiverges) {
    EXPECT_GT(errors_of(TransformKind::LoopLazy).back(), 1);
}

}  // namespace
}  // namespace mvw
