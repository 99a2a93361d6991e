#include "codec/enc_trials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "codec/decoder.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// A torus with waves on it, so that it is neither semi-regular nor told by few vertices.
Mesh wavy_torus() {
    Mesh mesh = torus(161, 97);
    for (Vec3& p : mesh.positions) p = p * (1 + 0.03 * std::sin(9 * p.x) * std::sin(11 * p.y) * std::sin(7 * p.z));
    return mesh;
}

Encoded encoded(const Mesh& mesh, const EncodeOptions& options) {
    const auto input = EncoderInput::make(mesh, options.threads).value();
    Encoded out;
    EXPECT_TRUE(best_draft(*input, options)->finish(options, out).ok());
    return out;
}

EncodeOptions on_one_thread() {
    EncodeOptions options;
    options.threads = 1;
    return options;
}

TEST(BestDraft, WhatIsSemiRegularNeedsNoTrial) {
    EncodeOptions options = on_one_thread();
    bool tried = false;
    options.progress = [&](const char* phase, double) { tried = tried || std::string(phase) == "choose"; };
    EXPECT_EQ(encoded(icosphere(4), options).base_faces, 20u);
    EXPECT_FALSE(tried);
}

TEST(BestDraft, BasesAndLevelsAskedForStay) {
    EncodeOptions options = on_one_thread();
    options.base_faces = 160;
    options.levels = 3;
    const Encoded out = encoded(torus(61, 37), options);
    EXPECT_LE(out.base_faces, 160u);
    EXPECT_GT(out.base_faces, 120u);
    EXPECT_EQ(out.levels, 3u);
}

TEST(BestDraft, OfManyVerticesHasTheLevelThatTrialsLeaveOut) {
    const Mesh mesh = wavy_torus();
    const SemiRegularMesh first = remesh(mesh, remeshing_of(on_one_thread())).parts.at(0);
    ASSERT_GE(first.levels, 3u);
    EncodeOptions options = on_one_thread();
    options.levels = static_cast<int>(first.levels) + 1;  // so many that a level is left out
    const Encoded out = encoded(mesh, options);
    EXPECT_EQ(out.levels, first.levels + 1);
    EXPECT_GT(out.vertices, 65'536u);
    EXPECT_GT(out.psnr, 80);
    options.threads = 3;
    EXPECT_EQ(encoded(mesh, options).file, out.file);
}

TEST(BestDraft, SeveralPartsAreTriedWithSeveralBases) {
    MVW_SKIP_WITHOUT_MODELS();
    const Mesh mesh = clean_model("human.obj");
    EncodeOptions options;
    options.threads = 2;
    RemeshResult first = remesh(mesh, remeshing_of(options));
    ASSERT_EQ(first.parts.size(), 2u);
    const auto input = EncoderInput::make(mesh, options.threads).value();
    const double score_of_first = Draft::make(*input, std::move(first), options)->score();
    EXPECT_GT(best_draft(*input, options)->score(), score_of_first + 0.3);
}

TEST(BestDraft, ABaseTooLargeForTheLeastSizeGetsSmaller) {
    MVW_SKIP_WITHOUT_MODELS();
    EncodeOptions options;
    options.threads = 2;
    const Encoded out = encoded(clean_model("demosthenes.obj"), options);
    EXPECT_GT(out.base_faces, 800u);  // no smaller than it must be
    Decoder decoder;
    ASSERT_TRUE(decoder.feed(ByteSpan(out.file).first(1024)).ok());
    EXPECT_TRUE(decoder.mesh().ok());
}

TEST(BestDraft, ColoursAndSeveralPartsPassThroughTrials) {
    Mesh mesh = join(wavy_torus(), moved(torus(40, 23), {4, 0, 0}));
    for (const Vec3& p : mesh.positions)
        mesh.colors.push_back({static_cast<std::uint8_t>(p.x > 2.5 ? 200 : 20), 100, 50, 255});
    const Encoded out = encoded(mesh, on_one_thread());
    const Mesh back = decode(out.file).value();
    ASSERT_EQ(back.colors.size(), back.positions.size());
    for (std::size_t v = 0; v < back.positions.size(); ++v)
        EXPECT_NEAR(back.colors[v].r, back.positions[v].x > 2.5 ? 200 : 20, 30);
}

}  // namespace
}  // namespace mvw
