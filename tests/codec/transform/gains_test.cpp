#include <gtest/gtest.h>

#include "codec/transform/reference/reference.h"
#include "tests/codec/transform/bases.h"

namespace mvw {
namespace {

// A flat piece of the regular lattice, one unit coefficient in its middle, the effect of it measured.
TEST(SynthesisGains, MatchTheEffectOfOneCoefficient) {
    for (const TransformKind kind : {TransformKind::Interp, TransformKind::SeededNormal, TransformKind::Loop,
                                     TransformKind::ButterflyLazy, TransformKind::Seeded}) {
        const BaseMesh base = test::grid(12, 12, false);
        const unsigned levels = 3;
        const TransformOptions options{.kind = kind};
        const std::vector<LevelGain> gains = synthesis_gains(options, levels);
        ASSERT_EQ(gains.size(), levels + 1);
        const ReferenceTransform transform(base, levels, options);
        const auto V = vertices_at_level(base, levels);
        std::vector<Vec3> flat(V), moved(V), zero(V);
        for (std::uint32_t v = 0; v < base.vertex_count(); ++v) {
            const std::uint32_t row = v / 13;
            const double x = v % 13, y = row;
            zero[v] = {x + y / 2, y * std::sqrt(0.75), 0};
        }
        transform.synthesize(zero, levels, flat);
        const double tiny = 1e-6;
        for (unsigned j = 1; j <= levels; ++j) {
            const std::uint32_t f = 2 * (6 * 12 + 6), n = 1u << j;
            const std::uint32_t v =
                j == 1 ? vertex_index(base, f, 1, 1, 1) : vertex_index(base, f, j, n / 2 - 1, n / 4);
            for (const std::size_t component : {std::size_t{0}, std::size_t{1}}) {
                std::vector<Vec3> coefficients = zero;
                coefficients[v][component] = tiny;
                transform.synthesize(coefficients, levels, moved);
                double sum = 0;
                for (std::size_t i = 0; i < V; ++i) sum += squared_length(moved[i] - flat[i]);
                const double wanted = component == 0 ? gains[j].normal : gains[j].tangential;
                EXPECT_NEAR(std::sqrt(sum) / tiny, wanted, 0.01 * wanted)
                    << transform_name(kind) << " level " << j << " component " << component;
            }
        }
    }
}

TEST(SynthesisGains, DoubleForEachCoarserLevel) {
    const std::vector<LevelGain> gains = synthesis_gains({}, 9);
    for (std::size_t j = 2; j < 8; ++j) EXPECT_NEAR(gains[j].normal / gains[j + 1].normal, 2, 0.3);
    EXPECT_DOUBLE_EQ(gains[2].normal, 2 * gains[3].normal);
}

}  // namespace
}  // namespace mvw
