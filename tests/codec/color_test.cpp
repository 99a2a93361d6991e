#include "codec/color.h"

#include <gtest/gtest.h>

#include <cmath>

#include "codec/decoder.h"
#include "tests/support/encoded_models.h"
#include "tests/support/semi_regular_models.h"

namespace mvw {
namespace {

/// A bumpy ball in smooth colours, half transparent below where asked for.
SemiRegularMesh colored_ball(unsigned levels, bool transparent) {
    SemiRegularMesh ball = bumpy_ball(levels);
    for (const Vec3& p : ball.positions) {
        const auto byte = [](double x) { return static_cast<std::uint8_t>(128 + 100 * x); };
        const Vec3 d = normalized(p);
        ball.colors.push_back({byte(std::sin(5 * d.x)), byte(d.y), byte(std::cos(4 * d.z)),
                               static_cast<std::uint8_t>(transparent && d.z < 0 ? 128 : 255)});
    }
    return ball;
}

double mean_error(const Mesh& a, const Mesh& b) {
    double sum = 0;
    for (std::size_t v = 0; v < a.colors.size(); ++v) {
        const Rgba8 &c = a.colors[v], &d = b.colors[v];
        sum += std::abs(c.r - d.r) + std::abs(c.g - d.g) + std::abs(c.b - d.b) + std::abs(c.a - d.a);
    }
    return sum / 4 / static_cast<double>(a.colors.size());
}

/// The colours of `ball` in the vertex order that the file has: by nearest position.
Mesh in_order_of(const SemiRegularMesh& ball, const Mesh& decoded) {
    Mesh out = decoded;
    for (std::size_t v = 0; v < decoded.positions.size(); ++v) {
        std::size_t best = 0;
        for (std::size_t u = 1; u < ball.positions.size(); ++u)
            if (squared_length(ball.positions[u] - decoded.positions[v]) <
                squared_length(ball.positions[best] - decoded.positions[v]))
                best = u;
        out.colors[v] = ball.colors[best];
    }
    return out;
}

TEST(Color, YCoCgAndBackIsExact) {
    for (unsigned n = 0; n < 4096; ++n) {
        const Rgba8 c{static_cast<std::uint8_t>(n * 7), static_cast<std::uint8_t>(n / 3),
                      static_cast<std::uint8_t>(n / 16), 255};
        EXPECT_EQ(to_rgba(to_ycocg(c), 1), c);
    }
}

TEST(Color, ColoursOfAWholeFileAreThoseOfTheMesh) {
    for (const bool transparent : {false, true})
        for (const unsigned levels : {0u, 3u}) {
            const SemiRegularMesh ball = colored_ball(levels, transparent);
            const Encoded e = encode_parts({ball});
            EXPECT_GT(e.color_bytes, 0u);
            const Mesh mesh = decode(e.file).value();
            ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
            EXPECT_LT(mean_error(mesh, in_order_of(ball, mesh)), 1.5) << levels << " levels";
        }
}

TEST(Color, EveryPrefixHasColoursOrNone) {
    const SemiRegularMesh ball = colored_ball(3, true);
    const Bytes file = encode_parts({ball}).file;
    std::size_t colored = 0;
    for (std::size_t n = 60; n < file.size(); n += 7) {
        const Result<Mesh> mesh = decode(ByteSpan(file).first(n));
        if (!mesh.ok()) continue;
        EXPECT_TRUE(mesh->colors.empty() || mesh->colors.size() == mesh->positions.size());
        colored += !mesh->colors.empty();
    }
    EXPECT_GT(colored, 20u);
}

TEST(Color, PartsWithoutColoursAreWhiteBesideOthers) {
    SemiRegularMesh plain_ball = bumpy_ball(2);
    for (Vec3& p : plain_ball.positions) p += Vec3{3, 0, 0};
    const Mesh mesh = decode(encode_parts({plain_ball, colored_ball(2, false)}).file).value();
    ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
    EXPECT_EQ(mesh.colors.front(), (Rgba8{255, 255, 255, 255}));
    EXPECT_NE(mesh.colors.back(), (Rgba8{255, 255, 255, 255}));
}

}  // namespace
}  // namespace mvw
