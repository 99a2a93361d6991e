#include "codec/remesh/feature_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "codec/measure/surface_error.h"
#include "codec/remesh/remesh.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// A prism over a regular polygon: faint edges along its height, sharp ones around its ends.
Mesh prism(std::uint32_t sides) {
    Mesh mesh;
    for (std::uint32_t k = 0; k < sides; ++k) {
        const double turn = 2 * std::numbers::pi * k / sides;
        mesh.positions.push_back({std::cos(turn), std::sin(turn), 0});
        mesh.positions.push_back({std::cos(turn), std::sin(turn), 1});
    }
    for (std::uint32_t k = 0; k < sides; ++k) {
        const std::uint32_t a = 2 * k, b = 2 * ((k + 1) % sides);
        mesh.faces.push_back({a, b, b + 1});
        mesh.faces.push_back({a, b + 1, a + 1});
        if (k == 0 || k + 1 == sides) continue;
        mesh.faces.push_back({0, b, a});
        mesh.faces.push_back({1, a + 1, b + 1});
    }
    return mesh;
}

std::size_t edges(const std::vector<std::uint8_t>& sharp) {
    return static_cast<std::size_t>(std::count(sharp.begin(), sharp.end(), 1)) / 2;
}

TEST(FeatureChoice, FollowsFaintEdgesOfMachinedPartsWhereTheyCostFewFaces) {
    const auto always_100 = [](const auto&) { return std::size_t{100}; };
    const ChosenFeatures cheap = choose_features(prism(24), always_100);
    EXPECT_EQ(cheap.angle_deg, 10);
    EXPECT_EQ(edges(cheap.sharp), 3u * 24);
    const auto two_thirds_more = [](const auto& sharp) { return edges(sharp) > 2u * 24 ? std::size_t{166} : 100; };
    const ChosenFeatures dear = choose_features(prism(24), two_thirds_more);
    EXPECT_EQ(dear.angle_deg, 25) << "no edge of 15 degrees is asked for";
    EXPECT_EQ(edges(dear.sharp), 2u * 24);
}

TEST(FeatureChoice, LeavesFaintEdgesOfOtherSurfaces) {
    const auto never = [](const auto&) {
        ADD_FAILURE() << "no need to ask";
        return std::size_t{0};
    };
    EXPECT_EQ(choose_features(icosphere(2), never).angle_deg, kFeatureAngleDeg);
}

TEST(FeatureChoice, KeepsRoundedCornersOfRealPartsAsTheyAre) {
    MVW_SKIP_WITHOUT_MODELS();
    const Mesh box = clean_model("box_assembly.stl");
    const RemeshResult remeshed = remesh(box, {});
    const SurfaceError error = surface_error(box, finest_mesh(remeshed.parts), {});
    EXPECT_GT(error.psnr, 120);
    EXPECT_LT(error.max, 5e-4) << "edges at most 0.05 % away";
    const Mesh adis = clean_model("adis16480.stl");
    EXPECT_GT(surface_error(adis, finest_mesh(remesh(adis, {}).parts), {}).psnr, 90);
}

}  // namespace
}  // namespace mvw
