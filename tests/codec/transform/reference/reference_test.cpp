#include "codec/transform/reference/reference.h"

#include <gtest/gtest.h>

#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

std::vector<TransformOptions> all_transforms() {
    std::vector<TransformOptions> all;
    for (unsigned k = 0; k < kTransformCount; ++k)
        for (const bool frames : {false, true})
            all.push_back({.kind = static_cast<TransformKind>(k), .local_frames = frames});
    all.push_back({.kind = TransformKind::Loop, .loop_template = 4});
    all.push_back({.kind = TransformKind::Interp, .s = 1.0});
    all.push_back({.kind = TransformKind::Interp, .table1_weights = true});
    return all;
}

TEST(ReferenceTransform, ReconstructsPerfectlyOnEveryBase) {
    for (const test::NamedBase& b : test::all_bases())
        for (const TransformOptions& options : all_transforms()) {
            const unsigned levels = 3;
            const auto V = vertices_at_level(b.base, levels);
            const std::vector<Vec3> positions = test::random_positions(V);
            std::vector<Vec3> coefficients(V), back(V);
            const ReferenceTransform transform(b.base, levels, options, b.creases);
            transform.analyze(positions, coefficients);
            transform.synthesize(coefficients, levels, back);
            // Loop's analysis amplifies noise, most at low valences: rounding is relative to what it holds.
            const double scale = std::max(1.0, test::largest_difference(coefficients, std::vector<Vec3>(V)));
            EXPECT_LT(test::largest_difference(positions, back), 1e-12 * scale)
                << b.name << " " << transform_name(options.kind) << (options.local_frames ? " frames" : "");
        }
}

TEST(ReferenceTransform, ReconstructsBothComponentsOfTheVectorTransform) {
    const TransformOptions options{.kind = TransformKind::Vector};
    for (const test::NamedBase& b : test::all_bases()) {
        const auto V = vertices_at_level(b.base, 3);
        const std::vector<Vec3> positions = test::random_positions(V);
        std::vector<Vec3> coefficients(V), back(V), shape(V);
        const ReferenceTransform transform(b.base, 3, options, b.creases);
        transform.analyze(positions, coefficients, shape);
        transform.synthesize(coefficients, 3, back, shape);
        EXPECT_LT(test::largest_difference(positions, back), 1e-12) << b.name;
        EXPECT_LT(test::largest_difference(std::vector<Vec3>(V), shape), 1e-12) << b.name;
    }
}

}  // namespace
}  // namespace mvw
