#include "codec/mesh/io/mesh_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <string_view>

#include "codec/mesh/io/files.h"
#include "tests/codec/mesh/io/samples.h"
#include "tests/support/meshes.h"
#include "tests/support/models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

using ::testing::HasSubstr;

Result<Mesh> read(const Sample& sample) {
    CleanReport report;
    return read_mesh_from_memory(sample.bytes, sample.format, report);
}

/// Runs within its own empty folder.
class MeshFiles : public ::testing::Test {
 protected:
    void SetUp() override {
        folder_ = std::filesystem::path(::testing::TempDir()) /
                  ("mvw_mesh_files_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
    [[nodiscard]] std::size_t files() const {
        return static_cast<std::size_t>(
            std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()));
    }

    std::filesystem::path folder_;
};

/// An icosphere with every attribute; no coordinate is a float32.
Mesh colorful_sphere() {
    Mesh mesh = scaled(icosphere(2), 0.1);
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
        mesh.colors.push_back({static_cast<std::uint8_t>(v), static_cast<std::uint8_t>(3 * v),
                               static_cast<std::uint8_t>(255 - v), static_cast<std::uint8_t>(128 + v % 128)});
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) mesh.materials.push_back(7 + 2 * (f / 100));
    return mesh;
}

TEST_F(MeshFiles, WhatIsWrittenReadsBack) {
    const Mesh mesh = colorful_sphere();
    for (const std::string name : {"a.ply", "a.obj", "a.off", "a.glb", "A.PLY"}) {
        SCOPED_TRACE(name);
        ASSERT_TRUE(write_mesh(path(name), mesh).ok());
        CleanReport report;
        const Result<Mesh> back = read_mesh(path(name), report);
        ASSERT_TRUE(back.ok()) << back.error().message;
        EXPECT_EQ(back->faces, mesh.faces);
        const bool decimal = name == "a.obj" || name == "a.off";
        ASSERT_EQ(back->positions.size(), mesh.positions.size());
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            // tinyobjloader's own arithmetic is off by units in the last place.
            const Vec3 expected = decimal ? mesh.positions[v] : to_double(to_float(mesh.positions[v]));
            EXPECT_LE(length(back->positions[v] - expected), name == "a.obj" ? 1e-16 : 0);
        }
        ASSERT_EQ(back->colors.size(), mesh.colors.size());
        for (std::size_t v = 0; v < mesh.colors.size(); ++v) {
            Rgba8 expected = mesh.colors[v];
            if (name == "a.obj") expected.a = 255;
            EXPECT_EQ(back->colors[v], expected);
        }
        if (name != "a.obj" && name != "a.glb") continue;
        ASSERT_EQ(back->materials.size(), mesh.materials.size());
        for (std::size_t f = 1; f < mesh.materials.size(); ++f)
            EXPECT_EQ(back->materials[f] == back->materials[f - 1], mesh.materials[f] == mesh.materials[f - 1]);
    }
    EXPECT_EQ(files(), 5u) << "nothing is left beside the results";
}

TEST_F(MeshFiles, StlReadsBackAfterWelding) {
    const Mesh mesh = icosphere(2);
    ASSERT_TRUE(write_mesh(path("a.stl"), mesh).ok());
    CleanReport report;
    Result<Mesh> back = read_mesh(path("a.stl"), report);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->positions.size(), 3 * mesh.faces.size());
    const Mesh welded = clean(std::move(back).value(), report);
    EXPECT_EQ(welded.positions.size(), mesh.positions.size());
    EXPECT_EQ(welded.faces.size(), mesh.faces.size());
}

TEST_F(MeshFiles, GltfViewersShowBothSidesOfWhatIsOpen) {
    const auto text = [&](const Mesh& mesh) {
        EXPECT_TRUE(write_mesh(path("a.glb"), mesh).ok());
        CleanReport report;
        const auto back = read_mesh(path("a.glb"), report);
        EXPECT_TRUE(back.ok() && back->materials.empty());
        const auto bytes = read_file(path("a.glb"));
        return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    };
    EXPECT_NE(text(unit_square()).find("\"doubleSided\":true"), std::string::npos);
    EXPECT_EQ(text(unit_cube()).find("doubleSided"), std::string::npos);
}

TEST_F(MeshFiles, SmallThingsFarAwayKeepTheirShape) {
    const Mesh mesh = moved(scaled(unit_cube(), 0.02), {1e6, -1e6, 0});
    for (const std::string name : {"a.ply", "a.obj", "a.off", "a.glb"}) {
        ASSERT_TRUE(write_mesh(path(name), mesh).ok());
        CleanReport report;
        const Result<Mesh> back = read_mesh(path(name), report);
        ASSERT_TRUE(back.ok()) << back.error().message;
        for (std::size_t v = 0; v < 8; ++v)
            EXPECT_LT(length(back->positions[v] - mesh.positions[v]), 0.04 * 1e-6) << name;
    }
}

TEST_F(MeshFiles, ErrorsNameTheFileAndTheReason) {
    CleanReport report;
    const auto error = [&](const std::string& name) {
        const Result<Mesh> mesh = read_mesh(path(name), report);
        return mesh ? std::string("no error") : mesh.error().message;
    };
    EXPECT_EQ(error("missing.ply"), path("missing.ply") + ": cannot be opened: No such file or directory");
    EXPECT_THAT(error("a.step"), HasSubstr(path("a.step") + ": has no known mesh format's ending"));
    std::filesystem::create_directories(path("folder.obj"));
    EXPECT_EQ(error("folder.obj"), path("folder.obj") + ": is not a regular file");
    ASSERT_TRUE(write_file(path("empty.stl"), {}).ok());
    EXPECT_EQ(error("empty.stl"), path("empty.stl") + ": is empty");
    const Result<void> written = write_mesh(path("nowhere/a.ply"), unit_cube());
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error().message, path("nowhere/a.ply") + ": cannot be written: No such file or directory");
    EXPECT_FALSE(write_mesh(path("a.gltf"), unit_cube()).ok());
    EXPECT_FALSE(write_mesh(path("a.stl"), scaled(unit_cube(), 1e39)).ok());
    EXPECT_EQ(files(), 2u);
}

TEST_F(MeshFiles, OuterBuffersComeFromBelowTheFileOnly) {
    std::filesystem::create_directories(path("scene"));
    const Bytes triangle = floats({0, 0, 0, 1, 0, 0, 0, 1, 0});
    ASSERT_TRUE(write_file(path("outside.bin"), triangle).ok());
    ASSERT_TRUE(write_file(path("scene/inside.bin"), triangle).ok());
    CleanReport report;
    for (const std::string uri : {"inside.bin", "../outside.bin", "none.bin"}) {
        ASSERT_TRUE(write_file(path("scene/a.gltf"), gltf_triangle(uri).bytes).ok());
        EXPECT_EQ(read_mesh(path("scene/a.gltf"), report).ok(), uri == "inside.bin") << uri;
    }
    EXPECT_FALSE(read(gltf_triangle("inside.bin")).ok());
}

TEST(MeshIo, ReadsEverySample) {
    for (const Sample& sample : good_samples()) {
        SCOPED_TRACE(sample.name);
        const Result<Mesh> mesh = read(sample);
        ASSERT_TRUE(mesh.ok()) << mesh.error().message;
        EXPECT_EQ(mesh->faces.size(), sample.faces);
        EXPECT_EQ(mesh->positions.size(), sample.vertices);
        EXPECT_EQ(mesh->colors.size(), sample.color ? sample.vertices : 0);
        EXPECT_TRUE(!sample.color || mesh->colors[1] == *sample.color);
    }
}

TEST(MeshIo, RefusesBadFilesWithAReason) {
    for (const BadSample& bad : bad_samples()) {
        SCOPED_TRACE(bad.sample.name);
        const Result<Mesh> mesh = read(bad.sample);
        ASSERT_FALSE(mesh.ok());
        EXPECT_THAT(mesh.error().message, HasSubstr(bad.reason));
        EXPECT_EQ(mesh.error().message.find('\n'), std::string::npos);
    }
}

TEST(MeshIo, EveryTruncationGivesAMeshOrAReason) {
    for (const Sample& sample : good_samples())
        for (std::size_t n = 0; n < sample.bytes.size(); ++n) {
            const Bytes prefix(sample.bytes.begin(), sample.bytes.begin() + static_cast<std::ptrdiff_t>(n));
            const Result<Mesh> mesh = read({sample.name, sample.format, prefix, 0, 0, {}});
            EXPECT_TRUE(mesh.ok() || !mesh.error().message.empty());
        }
}

TEST(MeshIo, EveryDamagedByteGivesAMeshOrAReason) {
    for (const Sample& sample : good_samples())
        for (std::size_t n = 0; n < sample.bytes.size(); ++n)
            for (const unsigned value : {0x00u, 0xFFu, 0x30u, 0x2Du}) {
                Bytes damaged = sample.bytes;
                damaged[n] = static_cast<std::byte>(value);
                const Result<Mesh> mesh = read({sample.name, sample.format, damaged, 0, 0, {}});
                if (!mesh) continue;
                for (const Face& f : mesh->faces)
                    for (const std::uint32_t v : f) ASSERT_LT(v, mesh->positions.size());
            }
}

TEST(Obj, IndicesCountBackAndSeamsStayClosed) {
    const Result<Mesh> mesh =
        read(obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\n"
                 "f -3/1/1 -2/2/1 -1/1/1\nv 0 0 1\nf 1//1 3//1 -1//1\nf 1/2 2/1 4/1\n"));
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->faces, (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}}));
}

TEST(Obj, MaterialsAreLabelsWhereThereIsMoreThanOne) {
    const std::string points = "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    Result<Mesh> mesh = read(obj(points + "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 1 4 2\nf 2 4 3\n"));
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->materials, (std::vector<std::uint32_t>{1, 2, 1, 1}));
    mesh = read(obj(points + "usemtl a\nf 1 2 3\nusemtl a\nf 1 3 4\n"));
    EXPECT_TRUE(mesh.ok() && mesh->materials.empty());
}

TEST(Obj, LargePolygonsAreWhole) {
    std::string text, face = "f";
    for (int i = 1; i <= 1000; ++i) {
        text += "v " + std::to_string(std::cos(i * 0.00628)) + " " + std::to_string(std::sin(i * 0.00628)) + " 0\n";
        face += " " + std::to_string(i);
    }
    CleanReport report;
    const Result<Mesh> mesh = read_mesh_from_memory(obj(text + face + "\n").bytes, MeshFormat::Obj, report);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->faces.size(), 998u);
    EXPECT_EQ(report.triangulated_polygons, 1u);
}

TEST(Gltf, NodesPlaceTheirMeshes) {
    // A root moved and scaled; a child turned by 90 degrees about z; another mirrored.
    const Result<Mesh> mesh = read(gltf_triangle(
        {}, R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[1,2],"translation":[10,0,0],"scale":[2,2,2]},)"
            R"({"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476]},)"
            R"({"mesh":0,"matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]}])"));
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    ASSERT_EQ(mesh->positions.size(), 6u);
    EXPECT_LT(length(mesh->positions[1] - Vec3{10, 2, 0}), 1e-12);
    EXPECT_LT(length(mesh->positions[2] - Vec3{8, 0, 0}), 1e-12);
    EXPECT_LT(length(mesh->positions[4] - Vec3{8, 0, 10}), 1e-12);
    EXPECT_EQ(mesh->faces, (std::vector<Face>{{0, 1, 2}, {3, 5, 4}})) << "a mirror turns the face round";
}

TEST(Gltf, MeshPlacedTooOftenIsRefused) {
    std::string nodes = R"("scenes":[{"nodes":[0)";
    for (int i = 1; i < 3000; ++i) nodes += "," + std::to_string(i);
    nodes += R"(]}],"nodes":[{"mesh":0})";
    for (int i = 1; i < 3000; ++i) nodes += R"(,{"mesh":0})";
    EXPECT_EQ(read(gltf_triangle({}, nodes + "]"))->faces.size(), 3000u) << "this often is fine";
    const Result<Mesh> twice =
        read(gltf_triangle({}, R"("scenes":[{"nodes":[0,1]}],"nodes":[{"children":[1]},{"mesh":0}])"));
    EXPECT_FALSE(twice.ok());
    const Result<Mesh> cycle = read(gltf_triangle({}, R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}])"));
    EXPECT_FALSE(cycle.ok());
}

TEST(Models, EachReadsOrSaysWhyNot) {
    MVW_SKIP_WITHOUT_MODELS();
    const std::vector<std::string> broken{"empty.off", "points_only.off", "index_out_of_range.off", "nan_vertex.off"};
    std::size_t seen = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(models_folder())) {
        const std::string file = std::filesystem::relative(entry.path(), models_folder()).string();
        const std::string name = file.substr(0, file.find(".zst"));
        if (!mesh_format_of(name)) continue;
        CleanReport report;
        const Result<Mesh> mesh = read_model(name, report);
        const bool fails = std::find(broken.begin(), broken.end(), entry.path().filename()) != broken.end();
        EXPECT_EQ(mesh.ok(), !fails) << name << ": " << (mesh ? "was read" : mesh.error().message);
        ++seen;
    }
    EXPECT_GE(seen, 55u);
}

TEST(Models, EveryTruncationOfTheSmallOnesGivesAMeshOrAReason) {
    MVW_SKIP_WITHOUT_MODELS();
    for (const auto& entry : std::filesystem::directory_iterator(models_folder() + "/tiny")) {
        const auto format = mesh_format_of(entry.path().string());
        if (!format) continue;
        const Result<Bytes> bytes = read_file(entry.path().string());
        ASSERT_TRUE(bytes.ok());
        for (std::size_t n = 0; n < bytes->size(); n += 1 + bytes->size() / 2000) {
            const Bytes prefix(bytes->begin(), bytes->begin() + static_cast<std::ptrdiff_t>(n));
            CleanReport report;
            const Result<Mesh> mesh = read_mesh_from_memory(prefix, *format, report);
            EXPECT_TRUE(mesh.ok() || !mesh.error().message.empty());
        }
    }
}

TEST(Models, FarFromTheOriginNoDigitIsLost) {
    MVW_SKIP_WITHOUT_MODELS();
    CleanReport report;
    const Result<Mesh> mesh = read_model("tiny/far_from_origin.off", report);
    ASSERT_TRUE(mesh.ok());
    EXPECT_EQ(mesh->positions[0], (Vec3{1000000.01, 1000000.01, 0.01}));
}

}  // namespace
}  // namespace mvw
