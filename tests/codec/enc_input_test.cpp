#include "codec/enc_input.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace mvw {
namespace {

TEST(EncoderInput, GivesEachPartItsFacesInCodedUnitsAndTheSameOneAgain) {
    const Mesh mesh = torus(12, 8);
    const auto input = EncoderInput::make(mesh, 1).value();
    RemeshResult remeshed;
    remeshed.part_of_face.assign(mesh.faces.size(), 0);
    for (std::size_t f = 0; f < mesh.faces.size(); f += 3) remeshed.part_of_face[f] = 1;
    PartSurface& part = input->part(remeshed, 1);
    ASSERT_EQ(part.mesh().faces.size(), (mesh.faces.size() + 2) / 3);
    EXPECT_EQ(part.mesh().faces[1], mesh.faces[3]);
    EXPECT_EQ(part.mesh().positions[5], input->to_coded_units(mesh.positions[5]));
    EXPECT_NEAR(length(part.mesh().positions[5]), length(mesh.positions[5]) / bounding_box(mesh).diagonal(), 1e-4);
    EXPECT_NE(&input->part(remeshed, 0), &part);
    EXPECT_EQ(&input->part(remeshed, 1), &part);
    remeshed.feature_angle_deg = 10;
    EXPECT_NE(&input->part(remeshed, 1), &part) << "walks of another kind";
}

TEST(EncoderInput, RefusesABoxThatTheHeaderCannotHold) {
    Mesh mesh = torus(12, 8);
    for (Vec3& p : mesh.positions) p *= 1e300;
    EXPECT_FALSE(EncoderInput::make(mesh, 1).ok());
}

}  // namespace
}  // namespace mvw
