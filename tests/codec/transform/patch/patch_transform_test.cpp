#include <gtest/gtest.h>

#include <optional>

#include "codec/transform/reference/reference.h"
#include "codec/transform/tables.h"
#include "codec/workers.h"
#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

std::vector<Vec3f> rounded(const std::vector<Vec3>& points) {
    std::vector<Vec3f> result;
    result.reserve(points.size());
    for (const Vec3& p : points) result.push_back(to_float(p));
    return result;
}
std::vector<Vec3> widened(const std::vector<Vec3f>& points) {
    std::vector<Vec3> result;
    result.reserve(points.size());
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
    PatchTransform(b.base, levels, options, b.creases).synthesize(given, levels, rebuilt);
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
        if (deep) expect_agreement(b, 5, {.kind = kind, .local_frames = frames});
    }
}

/// Bases of over 64 faces take groups of sixteen where the machine has vectors so wide.
TEST(PatchTransform, WideGroupsAgreeWithTheReference) {
    const test::NamedBase b{"holed torus", test::grid(6, 6, true, {7}), {}};
    ASSERT_GT(b.base.face_count(), 64u);
    for (const TransformKind kind : {TransformKind::Interp, TransformKind::SeededNormal, TransformKind::Vector})
        for (const unsigned levels : {2u, 4u}) expect_agreement(b, levels, {.kind = kind, .local_frames = false});
    expect_agreement(b, 2, {.kind = TransformKind::SeededNormal});
}

TEST(PatchTransform, ResultDoesNotDependOnThreads) {
    const test::NamedBase b{"", test::grid(9, 8, true, {6, 13, 40}), {}};
    const std::vector<Vec3f> positions = rounded(wavy_surface(b, 4));
    for (unsigned k = 0; k < kTransformCount; ++k) {
        const TransformOptions options{.kind = static_cast<TransformKind>(k)};
        std::vector<Vec3f> one(positions.size()), back_one(positions.size());
        PatchTransform(b.base, 4, options).analyze(positions, one);
        PatchTransform(b.base, 4, options).synthesize(one, 4, back_one);
        for (const unsigned threads : {2u, 3u, 5u}) {
            std::vector<Vec3f> many(positions.size()), back_many(positions.size());
            PatchTransform(b.base, 4, options, {}, threads).analyze(positions, many);
            PatchTransform(b.base, 4, options, {}, threads).synthesize(one, 4, back_many);
            EXPECT_EQ(one, many) << k;
            EXPECT_EQ(back_one, back_many) << k;
        }
        double worst = 0;
        for (std::size_t v = 0; v < positions.size(); ++v)
            worst = std::max(worst, double(length(positions[v] - back_one[v])));
        // Analysis by Loop amplifies rounding.
        const double scale = predict_rule(options.kind) == PredictRule::Loop ? 1e-3 : 1e-5;
        EXPECT_LT(worst, scale * std::max(1.0, largest(widened(one)))) << k;
    }
}

std::vector<Vec3f> surface_of(PatchTransform transform, const std::vector<Vec3f>& coefficients, const BaseMesh& base,
                              unsigned level) {
    std::vector<Vec3f> out(vertices_at_level(base, level));
    transform.synthesize(coefficients, level, out);
    return out;
}

TEST(TransformTables, ServeMoreAndMoreLevelsAndAreMadeByAnyThreads) {
    constexpr unsigned kSteps[] = {1, 4, 2, 6};
    for (const test::NamedBase& b : test::all_bases()) {
        SCOPED_TRACE(b.name);
        const TransformOptions options{.kind = TransformKind::SeededNormal};
        const std::vector<Vec3f> coefficients = rounded(test::random_positions(vertices_at_level(b.base, 6), 3));
        const auto tables = std::make_shared<TransformTables>(b.base, options, b.creases);
        Workers workers(3);
        unsigned made = 0;
        std::optional<PatchTransform> first;  // goes on with tables that have grown
        for (const unsigned levels : kSteps) {
            const std::size_t jobs = tables->jobs(levels);
            EXPECT_EQ(jobs > 0, levels > made) << levels;
            made = std::max(made, levels);
            workers.run([&](unsigned w) {
                for (std::size_t job = w; job < jobs; job += workers.count()) tables->make(job);
            });
            EXPECT_EQ(surface_of(PatchTransform(tables, levels), coefficients, b.base, levels),
                      surface_of(PatchTransform(b.base, levels, options, b.creases), coefficients, b.base, levels))
                << levels;
            if (!first) first.emplace(tables, 1);
        }
        EXPECT_EQ(surface_of(std::move(*first), coefficients, b.base, 1),
                  surface_of(PatchTransform(b.base, 1, options, b.creases), coefficients, b.base, 1));
        EXPECT_EQ(tables->jobs(6), 0u);
    }
}

TEST(PatchTransform, SecondComponentOfTheVectorTransformAgreesWithTheReference) {
    for (const test::NamedBase& b : test::all_bases()) {
        SCOPED_TRACE(b.name);
        const TransformOptions options{.kind = TransformKind::Vector, .local_frames = false};
        const std::vector<Vec3> positions = widened(rounded(wavy_surface(b, 4)));
        const std::size_t V = positions.size();
        std::vector<Vec3> wanted(V), wanted_second(V), back(V), back_second;
        const ReferenceTransform reference(b.base, 4, options, b.creases);
        reference.analyze(positions, wanted, wanted_second);
        std::vector<Vec3f> found(V), second(V), rebuilt(V), rebuilt_second(V);
        PatchTransform patch(b.base, 4, options, b.creases, 2);
        patch.analyze(rounded(positions), found, second);
        EXPECT_LT(test::largest_difference(wanted, widened(found)), 1e-5 * largest(wanted));
        EXPECT_LT(test::largest_difference(wanted_second, widened(second)), 1e-5 * largest(wanted));
        patch.synthesize(found, 4, rebuilt, second, rebuilt_second);
        EXPECT_LT(test::largest_difference(positions, widened(rebuilt)), 1e-5 * largest(wanted));
        EXPECT_LT(largest(widened(rebuilt_second)), 1e-5 * largest(wanted));
        // Where it comes from elsewhere, as a surface generator's does.
        for (Vec3f& x : second) x *= 2.0f;
        back_second = widened(second);
        reference.synthesize(widened(found), 4, back, back_second);
        patch.synthesize(found, 4, rebuilt, second, rebuilt_second);
        EXPECT_LT(test::largest_difference(back_second, widened(rebuilt_second)), 1e-5 * largest(wanted));
    }
}

/// Changes details of level >= first_level of these faces, sides included.
void change_details(const BaseMesh& base, const std::vector<std::uint32_t>& faces, unsigned first_level,
                    unsigned levels, std::vector<Vec3f>& coefficients) {
    std::vector<std::uint32_t> patch;
    for (const std::uint32_t f : faces)
        for (unsigned j = first_level; j <= levels; ++j) {
            patch_vertices(base, f, j, patch);
            std::size_t at = 0;
            const int n = 1 << j;
            for (int i = 0; i <= n; ++i)
                for (int k = 0; i + k <= n; ++k, ++at) {
                    const bool foreign = (k == 0 && !base.runs_along(f, 0)) || (i + k == n && !base.runs_along(f, 1)) ||
                                         (i == 0 && !base.runs_along(f, 2));
                    if (patch[at] >= vertices_at_level(base, j - 1) && !foreign)
                        coefficients[patch[at]] += Vec3f{0.01f, -0.02f, 0.005f};
                }
        }
}

TEST(PatchTransform, UpdateOfATileGivesTheBitsOfAWholeSynthesis) {
    const test::NamedBase b{"", test::grid(14, 12, true, {6, 13, 70}), {}};
    for (unsigned k = 0; k < kTransformCount; ++k)
        for (const bool frames : {true, false}) {
            const TransformOptions options{.kind = static_cast<TransformKind>(k), .local_frames = frames};
            SCOPED_TRACE(std::string(transform_name(options.kind)) + (frames ? " frames" : ""));
            const std::vector<Vec3f> positions = rounded(wavy_surface(b, 4));
            const std::size_t V = positions.size();
            std::vector<Vec3f> coefficients(V), kept(V), wanted(V);
            PatchTransform transform(b.base, 4, options, {}, 2, true);
            transform.analyze(positions, coefficients);
            transform.synthesize(coefficients, 4, kept);
            const std::vector<std::vector<std::uint32_t>> tiles{{5, 6, 7}, {100, 101}, {200}, {}};
            for (unsigned round = 0; round < tiles.size(); ++round) {
                const unsigned first_level = 1 + (round + 2) % 4;
                change_details(b.base, tiles[round], first_level, 4, coefficients);
                transform.update(coefficients, tiles[round], first_level, 4, kept);
                PatchTransform(b.base, 4, options).synthesize(coefficients, 4, wanted);
                EXPECT_EQ(kept, wanted) << "round " << round;
            }
        }
}

TEST(PatchTransform, UpdateFallsBackWhereThereIsNothingToBuildOn) {
    const test::NamedBase b{"", test::bipyramid(5), {}};
    std::vector<Vec3f> coefficients = rounded(wavy_surface(b, 4));
    for (const bool updates : {true, false}) {
        PatchTransform transform(b.base, 4, {}, {}, 1, updates);
        for (const unsigned level : {3u, 4u, 4u, 2u, 0u}) {
            std::vector<Vec3f> found(vertices_at_level(b.base, level)), wanted(found.size());
            coefficients[0].x += 0.1f;  // a base vertex: first_level 0
            transform.update(coefficients, {}, 0, level, found);
            PatchTransform(b.base, 4, {}).synthesize(coefficients, level, wanted);
            EXPECT_EQ(found, wanted) << level;
        }
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

TEST(PatchTransform, TakesAtMostThreeTimesThePositionsFromFiveLevelsUp) {
    const BaseMesh base = test::grid(10, 10, true);
    for (unsigned k = 0; k < kTransformCount; ++k) {
        const auto kind = static_cast<TransformKind>(k);
        const double positions = 12.0 * double(vertices_at_level(base, 5));
        // The vector transform's second component is as much again.
        const double limit = kind == TransformKind::Vector ? 5 : 3;
        EXPECT_LT(double(PatchTransform(base, 5, {.kind = kind}).memory_bytes()), limit * positions) << k;
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, PatchTransformOf, testing::Range(0u, kTransformCount), [](const auto& kind) {
    std::string name(transform_name(static_cast<TransformKind>(kind.param)));
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
});

}  // namespace
}  // namespace mvw
