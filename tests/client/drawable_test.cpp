#include "client/drawable.h"

#include <gtest/gtest.h>

#include "tests/support/encoded_models.h"
#include "tests/support/shapes.h"

namespace mvw::client {
namespace {

/// A part of one level: each mesh's faces are its base's.
SemiRegularMesh part_of(const Mesh& mesh) {
    SemiRegularMesh part;
    part.base = BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces).value();
    part.positions = mesh.positions;
    return part;
}

bool drawn_as_solid(std::vector<SemiRegularMesh> parts) {
    const Encoded encoded = encode_parts(std::move(parts));
    Decoder decoder;
    EXPECT_TRUE(decoder.feed(encoded.file).ok());
    const auto drawable = make_drawable(decoder, {});
    EXPECT_TRUE(drawable.ok());
    return drawable.ok() && drawable->solid;
}

TEST(Drawable, IsSolidWhereAllItsPartsAre) {
    const SemiRegularMesh ball = part_of(icosphere(1)), other = part_of(moved(icosphere(1), {5, 0, 0}));
    Mesh bowl = moved(icosphere(1), {-5, 0, 0});
    bowl.faces.pop_back();
    EXPECT_TRUE(drawn_as_solid({ball}));
    EXPECT_TRUE(drawn_as_solid({ball, other}));
    EXPECT_FALSE(drawn_as_solid({part_of(bowl)}));
    EXPECT_FALSE(drawn_as_solid({part_of(bowl), ball}));
    EXPECT_FALSE(drawn_as_solid({ball, part_of(bowl)}));
}

}  // namespace
}  // namespace mvw::client
