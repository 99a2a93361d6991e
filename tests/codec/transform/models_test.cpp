// Every transform on real meshes of subdivision connectivity: closed, open, creased.
#include <gtest/gtest.h>

#include "codec/remesh/recognize.h"
#include "codec/transform/reference/reference.h"
#include "codec/transform/transform.h"
#include "tests/codec/transform/bases.h"
#include "tests/support/models.h"
#include "tests/support/semi_regular_models.h"

namespace mvw {
namespace {

struct Source {
    const char* file;
    unsigned levels;
    std::uint32_t base_faces;
    bool in_level_order = true;  // else its levels are recognised
};

SemiRegularMesh load(const Source& source, const Mesh& mesh) {
    if (source.in_level_order) return from_level_order(mesh, source.levels);
    const Recognition found = recognize(mesh, 1);
    SemiRegularMesh model;
    if (found.meshes.size() != 1) return model;
    model.base = found.meshes[0].base;
    model.levels = found.meshes[0].levels;
    for (const std::uint32_t v : found.meshes[0].vertices) model.positions.push_back(mesh.positions[v]);
    return model;
}

class TransformsOf : public testing::TestWithParam<Source> {};

double diagonal(const std::vector<Vec3>& points) {
    Box box;
    for (const Vec3& p : points) box.add(p);
    return box.diagonal();
}

TEST_P(TransformsOf, ReconstructAndAgree) {
    MVW_SKIP_WITHOUT_MODELS();
    CleanReport report;
    const auto read = read_model(GetParam().file, report);
    ASSERT_TRUE(read.ok()) << read.error().message;
    SemiRegularMesh model = load(GetParam(), *read);
    ASSERT_EQ(model.base.face_count(), GetParam().base_faces);
    ASSERT_EQ(model.levels, GetParam().levels);
    // Both sides start from the same numbers.
    std::vector<Vec3f> given;
    for (Vec3& p : model.positions) {
        given.push_back(to_float(p));
        p = to_double(given.back());
    }
    const std::size_t V = model.positions.size();
    const double size = diagonal(model.positions);
    for (unsigned k = 0; k < kTransformCount; ++k) {
        const TransformOptions options{.kind = static_cast<TransformKind>(k), .local_frames = false};
        SCOPED_TRACE(transform_name(options.kind));
        const ReferenceTransform reference(model.base, model.levels, options);
        std::vector<Vec3> wanted(V), back(V);
        reference.analyze(model.positions, wanted);
        reference.synthesize(wanted, model.levels, back);
        double scale = size;
        for (const Vec3& c : wanted) scale = std::max(scale, length(c));
        EXPECT_LT(test::largest_difference(back, model.positions), 1e-12 * scale);
        std::vector<Vec3f> found(V), rebuilt(V);
        PatchTransform(model.base, model.levels, options, {}, 2).analyze(given, found);
        PatchTransform(model.base, model.levels, options, {}, 2).synthesize(found, model.levels, rebuilt);
        double apart = 0, lost = 0;
        for (std::size_t v = 0; v < V; ++v) {
            apart = std::max(apart, length(to_double(found[v]) - wanted[v]));
            lost = std::max(lost, length(to_double(rebuilt[v]) - model.positions[v]));
        }
        // Analysis by lazy Loop inverts an averaging without a lift: it amplifies whatever rounding leaves.
        EXPECT_LT(apart, (options.kind == TransformKind::LoopLazy ? 1e-4 : 1e-5) * scale);
        EXPECT_LT(lost, 1e-5 * scale);
    }
}

/// Two levels over two thousand base faces: grids have no idle points, the rest is lists at base vertices.
TEST(PatchTransform, TakesFewBytesForAShallowModel) {
    MVW_SKIP_WITHOUT_MODELS();
    CleanReport report;
    const auto read = read_model("sr_boat.obj", report);
    ASSERT_TRUE(read.ok()) << read.error().message;
    const SemiRegularMesh boat = load({"sr_boat.obj", 2, 2026, false}, *read);
    const double positions = double(boat.positions.size() * sizeof(Vec3f));
    const auto bytes = [&](TransformKind kind, bool frames) {
        return double(PatchTransform(boat.base, 2, {.kind = kind, .local_frames = frames}).memory_bytes()) / positions;
    };
    EXPECT_LT(bytes(TransformKind::Interp, false), 12.5);
    EXPECT_LT(bytes(TransformKind::SeededNormal, true), 16.5);
}

INSTANTIATE_TEST_SUITE_P(Models, TransformsOf,
                         testing::Values(Source{"sr_bunny_oct7.ply", 7, 8}, Source{"sr_club.ply", 3, 299},
                                         Source{"sr_stell.ply", 4, 60}, Source{"sr_canyon_513.ply", 7, 32},
                                         Source{"sr_boat.obj", 2, 2026, false}),
                         [](const auto& source) {
                             const std::string name = source.param.file;
                             return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace mvw
