#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "codec/container/enc_file.h"
#include "codec/decoder.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/material_colors.h"
#include "tests/support/encoded_models.h"
#include "tests/support/golden_models.h"
#include "tests/support/program.h"

namespace mvw {
namespace {

std::string data(const std::string& name) {
    return test_data_folder() + "/" + name;
}

TEST(Golden, FilesOfEveryTransformAndProfileDecodeAsTheyAlwaysDid) {
    for (const GoldenModel& model : golden_models()) {
        SCOPED_TRACE(model.name);
        const Result<Bytes> file = read_file(data(golden_file(model.name)));
        CleanReport report;
        const Result<Mesh> expected = read_mesh(data(golden_mesh(model.name)), report);
        ASSERT_TRUE(file.ok() && expected.ok());
        Mesh mesh = decode(*file).value();
        (void)colors_to_vertices(mesh);  // as files of meshes have them
        ASSERT_EQ(mesh.faces, expected->faces);
        ASSERT_EQ(mesh.positions.size(), expected->positions.size());
        // Far below every step: one symbol read otherwise would show.
        const double tolerance = 1e-6 * bounding_box(*expected).diagonal();
        for (std::size_t v = 0; v < mesh.positions.size(); ++v)
            EXPECT_LT(length(mesh.positions[v] - expected->positions[v]), tolerance) << "vertex " << v;
        ASSERT_EQ(mesh.colors.size(), expected->colors.size());
        for (std::size_t v = 0; v < mesh.colors.size(); ++v)
            EXPECT_LE(std::abs(mesh.colors[v].r - expected->colors[v].r), 1) << "vertex " << v;
    }
}

TEST(Golden, TheirCoefficientsAreTheSameBitForBit) {
    for (const GoldenModel& model : golden_models()) {
        Decoder decoder;
        ASSERT_TRUE(decoder.feed(read_file(data(golden_file(model.name))).value()).ok());
        const Bytes expected = read_file(data(golden_digest(model.name))).value();
        EXPECT_EQ(fmt::format("{:016x}\n", decoder.coefficient_digest()),
                  std::string(reinterpret_cast<const char*>(expected.data()), expected.size()))
            << model.name;
    }
}

TEST(Golden, TheirHeadersAndContentIdsAreThose) {
    const Bytes file = read_file(data(golden_file("mixed"))).value();
    const FileHeader header = read_header(file).value();
    EXPECT_EQ(header.version, kFormatVersion);
    EXPECT_EQ(header.parts.size(), 3u);
    EXPECT_EQ(header.parts[0].tiles, 2);
    EXPECT_EQ(content_id_of(file).value(), header.content_id);
    EXPECT_EQ(decode(file)->materials.size(), decode(file)->faces.size());
}

TEST(Golden, TheWorkedExampleOfTheFormatDecodes) {
    const std::string hex =
        "4d56570a2a00887809899b62fe2a03069b45c6d32957b4ddf2ff0000000901010004000401004610"
        "8a3e00004116eb00ff8e50505080808037000404"
        "00030000012f01011001ff000101000503000001010101000e030110012027011003005c90f5bffe"
        "d3ffd00205f0fffffa0f0000000100004195ce965beaf201e3a647bc";
    Bytes file;
    for (std::size_t i = 0; i < hex.size(); i += 2)
        file.push_back(static_cast<std::byte>(std::stoi(hex.substr(i, 2), nullptr, 16)));
    Decoder decoder;
    ASSERT_TRUE(decoder.feed(file).ok());
    EXPECT_TRUE(decoder.state().complete);
    EXPECT_EQ(content_id_of(file).value(), toc_of(file).header.content_id);
    const Mesh mesh = decoder.mesh().value();
    ASSERT_EQ(mesh.faces.size(), 4u);
    for (const Vec3& p : mesh.positions)
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(std::abs(p[k]), 1, 1e-6);
}

}  // namespace
}  // namespace mvw
