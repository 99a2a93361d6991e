#include "codec/enc_trials.h"

#include <gtest/gtest.h>

#include <string>

#include "codec/measure/surface_error.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

Way way_of(const Mesh& mesh, const EncodeOptions& options) {
    const auto input = EncoderInput::make(mesh, options.threads).value();
    return choose_way(*input, remesh(mesh, remeshing_of(options)), options);
}

EncodeOptions one_thread() {
    EncodeOptions options;
    options.threads = 1;
    return options;
}

TEST(ChooseWay, WhatIsSemiRegularNeedsNoTrial) {
    EncodeOptions options = one_thread();
    bool tried = false;
    options.progress = [&](const char* phase, double) { tried = tried || std::string(phase) == "choose"; };
    const Way way = way_of(icosphere(4), options);
    EXPECT_TRUE(way.as_first);
    EXPECT_EQ(way.transform, options.transform.kind);
    EXPECT_FALSE(tried);
}

TEST(ChooseWay, ABaseThatIsAskedForStays) {
    EncodeOptions options = one_thread();
    options.base_faces = 60;
    const Way way = way_of(torus(61, 37), options);
    EXPECT_TRUE(way.as_first);
    EXPECT_EQ(way.remeshing.base_faces, 60u);
}

TEST(ChooseWay, AnotherBaseHasTheFacesAndLevelsThatItsTrialStandsFor) {
    const Mesh mesh = torus(61, 37);
    const RemeshResult first = remesh(mesh, remeshing_of(one_thread()));
    const Way way = way_of(mesh, one_thread());
    const RemeshResult taken = remesh(mesh, way.remeshing);
    ASSERT_EQ(taken.parts.size(), 1u);
    const double ratio = double(taken.parts[0].base.face_count()) / first.parts[0].base.face_count();
    EXPECT_EQ(way.as_first, way.remeshing.base_faces == 0);
    EXPECT_GT(ratio, way.as_first ? 0.99 : 1 / 2.7);
    EXPECT_LT(ratio, way.as_first ? 1.01 : 1.7);
    // No trial may end in a file that stands far worse.
    const auto error = [&](const RemeshResult& remeshed) {
        const SemiRegularMesh& part = remeshed.parts[0];
        return surface_error(mesh, {part.positions, triangles_at_level(part.base, part.levels), {}, {}}, {20'000, 1})
            .rms;
    };
    EXPECT_LT(error(taken), std::max(2 * error(first), 1e-4));
}

TEST(ChooseWay, SmoothModelsAreLifted) {
    EXPECT_EQ(way_of(torus(61, 37), one_thread()).transform, TransformKind::SeededNormal);
}

}  // namespace
}  // namespace mvw
