#include <gtest/gtest.h>

#include "codec/container/enc_file.h"
#include "codec/decoder.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tests/support/program.h"

namespace mvw {
namespace {

std::string data(const std::string& name) {
    return test_data_folder() + "/" + name;
}

TEST(Golden, AFileOfVersionOneDecodesAsItAlwaysDid) {
    const Bytes file = read_file(data("golden_v1.mvw")).value();
    CleanReport report;
    const Mesh expected = read_mesh(data("golden_v1.off"), report).value();
    const Mesh mesh = decode(file).value();
    ASSERT_EQ(mesh.faces, expected.faces);
    ASSERT_EQ(mesh.positions.size(), expected.positions.size());
    const double diagonal = bounding_box(expected).diagonal();
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        EXPECT_LT(length(mesh.positions[v] - expected.positions[v]), 1e-6 * diagonal) << "vertex " << v;
    EXPECT_EQ(mesh.materials.size(), mesh.faces.size());
}

TEST(Golden, ItsHeaderAndContentIdAreThose) {
    const Bytes file = read_file(data("golden_v1.mvw")).value();
    const FileHeader header = read_header(file).value();
    EXPECT_EQ(header.version, 1);
    EXPECT_EQ(header.parts.size(), 3u);
    EXPECT_EQ(header.parts[0].tiles, 2);
    EXPECT_EQ(content_id_of(file).value(), header.content_id);
}

}  // namespace
}  // namespace mvw
