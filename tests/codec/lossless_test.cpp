#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "codec/container/toc.h"
#include "codec/decoder.h"
#include "codec/encoder.h"
#include "tests/support/encoded_models.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/semi_regular_models.h"

namespace mvw {
namespace {

using Triangle = std::array<std::array<std::int64_t, 3>, 3>;

/// Every face by its corners on the file's grid, each turned to its least rotation, sorted: equal for equal meshes
/// whatever their order of vertices and faces.
std::vector<Triangle> on_grid(const Mesh& mesh, const FileHeader& header, unsigned bits) {
    std::vector<Triangle> out;
    const Vec3 center{header.center[0], header.center[1], header.center[2]};
    for (const Face& f : mesh.faces) {
        Triangle t{};
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3 p = (mesh.positions[f[c]] - center) / header.diagonal;
            for (std::size_t k = 0; k < 3; ++k) t[c][k] = std::llround(std::ldexp(p[k], int(bits)));
        }
        const Triangle second{t[1], t[2], t[0]}, third{t[2], t[0], t[1]};
        out.push_back(std::min({t, second, third}));
    }
    std::sort(out.begin(), out.end());
    return out;
}

Bytes lossless(const Mesh& mesh, unsigned bits, Profile profile = Profile::Small) {
    EncodeOptions options;
    options.lossless = bits;
    options.profile = profile;
    options.threads = 1;
    return encode(mesh, options).value().file;
}

void expect_exact(const Mesh& mesh, const Bytes& file, unsigned bits) {
    const FileHeader header = read_header(file).value();
    const Mesh back = decode(file).value();
    ASSERT_EQ(back.positions.size(), mesh.positions.size());
    EXPECT_TRUE(on_grid(back, header, bits) == on_grid(mesh, header, bits));
    double off_grid = 0;
    for (const Vec3& p : back.positions)
        for (std::size_t k = 0; k < 3; ++k) {
            const double q = std::ldexp((p[k] - header.center[k]) / header.diagonal, int(bits));
            off_grid = std::max(off_grid, std::abs(q - std::round(q)));
        }
    EXPECT_LT(off_grid, 1e-6) << "decoded positions are the grid's";
}

class LosslessModels : public testing::TestWithParam<const char*> {};

TEST_P(LosslessModels, SemiRegularInputComesBackExactly) {
    MVW_SKIP_WITHOUT_MODELS();
    const Mesh mesh = clean_model(GetParam());
    const Bytes file = lossless(mesh, 16);
    EXPECT_GE(read_header(file)->parts[0].levels, 2) << "by wavelets, not by Draco";
    expect_exact(mesh, file, 16);
}

INSTANTIATE_TEST_SUITE_P(Models, LosslessModels,
                         testing::Values("sr_bunny_oct7.ply", "sr_canyon_513.ply", "sr_club.ply", "sr_stell.ply",
                                         "sr_boat.obj"));

TEST(Lossless, EveryPrecisionAndProfileIsExact) {
    const Mesh ball = plain(bumpy_ball(4));
    for (const unsigned bits : {4u, 8u, 17u, 24u}) {
        SCOPED_TRACE(bits);
        expect_exact(ball, lossless(ball, bits), bits);
        expect_exact(ball, lossless(ball, bits, Profile::Fast), bits);
    }
}

TEST(Lossless, BeginningsAreMeshesThatComeNearer) {
    const Mesh ball = plain(bumpy_ball(4));
    const Bytes file = lossless(ball, 16);
    float before = 1;
    for (const ChunkEntry& c : toc_of(file).chunks) {
        EXPECT_LE(c.error, before);
        before = c.error;
        EXPECT_TRUE(decode(ByteSpan(file).first(c.offset + c.length)).ok());
    }
    EXPECT_GT(toc_of(file).chunks.size(), 5u);
}

TEST(Lossless, WhatIsNotSemiRegularIsRefused) {
    EncodeOptions options;
    options.lossless = 14;
    const Result<Encoded> encoded = encode(tetrahedron_mesh(), options);
    ASSERT_FALSE(encoded.ok());
    EXPECT_EQ(encoded.error().code, Errc::InvalidArgument);
}

}  // namespace
}  // namespace mvw
