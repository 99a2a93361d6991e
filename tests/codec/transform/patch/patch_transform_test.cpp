#include <gtest/gtest.h>

#include "codec/transform/reference/reference.h"
#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

std::vector<Vec3f> rounded(const std::vector<Vec3>& points) {
    std::vector<Vec3f> result;
    for (const Vec3& p : points) result.push_back(to_float(p));
    return result;
}
std::vector<Vec3> widened(const std::vector<Vec3f>& points) {
    std::vector<Vec3> result;
    for (const Vec3f& p : points) result.push_back(to_double(p));
    return result;
}
double largest(const std::vector<Vec3>& points) {
    return test::largest_difference(points, std::vector<Vec3>(points.size()));
}

/// A wavy surface over the base: its vertices at random, the others by subdivision plus a shrinking random detail.
std::vector<Vec3> wavy_surface(const test::NamedBase& b, unsigned levels) {
    const auto V = vertices_at_level(b.base, levels);
    std::vector<Vec3> coefficients = test::random_positions(V, 7);
    for (unsigned j = 1; j <= levels; ++j)
        for (auto v = vertices_at_level(b.base, j - 1); v < vertices_at_level(b.base, j); ++v)
            coefficients[v] *= 0.3 / double(1u << (2 * j));
    std::vector<Vec3> positions(V);
    ReferenceTransform(b.base, levels, {.kind = TransformKind::InterpLazy, .local_frames = false}, b.creases)
        .synthesize(coefficients, levels, positions);
    return positions;
}

class PatchTransformOf : public testing::TestWithParam<unsigned> {};

void expect_agreement(const test::NamedBase& b, unsigned levels, const TransformOptions& options) {
    SCOPED_TRACE(b.name + ", levels " + std::to_string(levels) + (options.local_frames ? ", frames" : ""));
    const std::vector<Vec3> positions = widened(rounded(wavy_surface(b, levels)));
    std::vector<Vec3> wanted(positions.size()), back(positions.size());
    const ReferenceTransform reference(b.base, levels, options, b.creases);
    reference.analyze(positions, wanted);
    PatchTransform patch(b.base, levels, options, b.creases);
    std::vector<Vec3f> found(positions.size()), rebuilt(positions.size());
    patch.analyze(rounded(positions), found);
    const double scale = largest(wanted);
    EXPECT_LT(test::largest_difference(wanted, widened(found)), 1e-5 * scale);
    const std::vector<Vec3f> given = rounded(wanted);
    reference.synthesize(widened(given), levels, back);
    patch.synthesize(given, levels, rebuilt);
    EXPECT_LT(test::largest_difference(back, widened(rebuilt)), 1e-5 * scale);
}

TEST_P(PatchTransformOf, AgreesWithTheReference) {
    const auto kind = static_cast<TransformKind>(GetParam());
    // Loop's analysis crumples these rough surfaces until normals cancel: frames would hang on the last bit.
    const bool frames = predict_rule(kind) != PredictRule::Loop;
    for (const test::NamedBase& b : test::all_bases()) {
        expect_agreement(b, 1, {.kind = kind, .local_frames = frames});
        expect_agreement(b, 2, {.kind = kind, .local_frames = frames});
        expect_agreement(b, 4, {.kind = kind, .local_frames = false});
        // Stencils of levels this fine are carried over from coarser ones.
        const bool deep = b.name == "fan 5" || b.name == "creased square" || b.name == "sheet with hole";
        if (deep) expect_agreement(b, 6, {.kind = kind, .local_frames = frames});
    }
}

TEST(PatchTransform, ResultDoesNotDependOnThreads) {
    for (const TransformKind kind : {TransformKind::SeededNormal, TransformKind::Loop}) {
        const test::NamedBase b{"", test::grid(5, 5, true, {6, 13}), {}};
        const std::vector<Vec3f> positions = rounded(wavy_surface(b, 4));
        std::vector<Vec3f> one(positions.size()), three(positions.size());
        PatchTransform(b.base, 4, {.kind = kind}, {}, 1).analyze(positions, one);
        PatchTransform(b.base, 4, {.kind = kind}, {}, 3).analyze(positions, three);
        EXPECT_EQ(one, three);
        std::vector<Vec3f> back_one(positions.size()), back_three(positions.size());
        PatchTransform(b.base, 4, {.kind = kind}, {}, 1).synthesize(one, 4, back_one);
        PatchTransform(b.base, 4, {.kind = kind}, {}, 3).synthesize(one, 4, back_three);
        EXPECT_EQ(back_one, back_three);
        double worst = 0;
        for (std::size_t v = 0; v < positions.size(); ++v)
            worst = std::max(worst, double(length(positions[v] - back_one[v])));
        EXPECT_LT(worst, 1e-5);
    }
}

TEST(PatchTransform, StopsAtAnyLevel) {
    const test::NamedBase b{"", test::bipyramid(5), {}};
    std::vector<Vec3f> coefficients = rounded(wavy_surface(b, 4));
    PatchTransform transform(b.base, 4, {});
    for (unsigned level = 0; level <= 4; ++level) {
        const auto V = vertices_at_level(b.base, level);
        std::vector<Vec3f> short_one(V), same(V);
        transform.synthesize(coefficients, level, short_one);
        PatchTransform(b.base, level, {}).synthesize(std::span(coefficients).first(V), level, same);
        EXPECT_EQ(short_one, same) << level;
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, PatchTransformOf, testing::Range(0u, kTransformCount), [](const auto& kind) {
    std::string name(transform_name(static_cast<TransformKind>(kind.param)));
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
});

}  // namespace
}  // namespace mvw
