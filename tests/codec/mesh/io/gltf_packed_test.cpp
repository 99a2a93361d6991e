// Compressed, sparse and instanced glTF reads like the plain file.
#include "codec/mesh/io/gltf_unpack.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>

#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/io/text.h"
#include "tests/support/meshes.h"
#include "tests/support/program.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

using ::testing::HasSubstr;

std::string base64(ByteSpan bytes) {
    constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k)
            three = three << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? kLetters[three >> (18 - 6 * k) & 63u] : '=';
    }
    return out;
}

/// The lists of a glTF file, each grown by adding to it.
struct Gltf {
    Bytes data;
    std::string views, accessors, primitive, node = R"("mesh":0)", more_buffers, more;

    /// The view of bytes that are put behind the others.
    int add_view(ByteSpan bytes, const std::string& members = {}) {
        data.resize((data.size() + 3) / 4 * 4);
        const std::size_t at = data.size();
        data.insert(data.end(), bytes.begin(), bytes.end());
        return add(views, fmt::format(R"("buffer":0,"byteOffset":{},"byteLength":{}{})", at, bytes.size(), members));
    }
    int add_accessor(const std::string& members) { return add(accessors, members); }

    [[nodiscard]] std::string json(bool with_data = true) const {
        const std::string uri =
            with_data ? R"(,"uri":"data:application/octet-stream;base64,)" + base64(data) + "\"" : "";
        return fmt::format(R"({{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}{}}}{}],"bufferViews":[{}],)"
                           R"("accessors":[{}],"meshes":[{{"primitives":[{{{}}}]}}],"nodes":[{{{}}}],)"
                           R"("scenes":[{{"nodes":[0]}}]{}}})",
                           data.size(), uri, more_buffers, views, accessors, primitive, node, more);
    }
    [[nodiscard]] Bytes glb() const {
        std::string text = json(false);
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const auto padded = static_cast<std::uint32_t>((data.size() + 3) / 4 * 4);
        ByteWriter out;
        for (const std::uint32_t word : {0x46546C67u, 2u, static_cast<std::uint32_t>(28 + text.size()) + padded,
                                         static_cast<std::uint32_t>(text.size()), 0x4E4F534Au})
            out.u32(word);
        out.bytes(as_bytes(text));
        out.u32(padded);
        out.u32(0x004E4942u);
        out.bytes(data);
        for (std::size_t k = data.size(); k < padded; ++k) out.u8(0);
        return out.take();
    }

 private:
    static int add(std::string& list, const std::string& members) {
        const auto before = static_cast<int>(std::count(list.begin(), list.end(), '\n'));  // one behind each
        list += (before == 0 ? "{" : ",{") + members + "}\n";
        return before;
    }
};

/// Positions that quantisation keeps: multiples of 1/64.
Mesh sample() {
    Mesh mesh = icosphere(2);
    for (Vec3& p : mesh.positions)
        p = {std::round(p.x * 64) / 64, std::round(p.y * 64) / 64, std::round(p.z * 64) / 64};
    return mesh;
}

Bytes floats_of(const Mesh& mesh) {
    ByteWriter out;
    for (const Vec3& p : mesh.positions)
        for (const double x : {p.x, p.y, p.z}) out.f32(static_cast<float>(x));
    return out.take();
}
std::vector<std::uint32_t> corners_of(const Mesh& mesh) {
    std::vector<std::uint32_t> out;
    for (const Face& f : mesh.faces) out.insert(out.end(), f.begin(), f.end());
    return out;
}

Result<Mesh> read(const std::string& json) {
    CleanReport report;
    return read_mesh_from_memory(as_bytes(json), MeshFormat::Gltf, report);
}

/// Triangles as positions, from the least corner on, in order: the same whatever vertices are called.
std::vector<std::array<double, 9>> triangles_of(const Mesh& mesh) {
    std::vector<std::array<double, 9>> out;
    for (const Face& f : mesh.faces) {
        std::array<std::array<double, 3>, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k)
            corners[k] = {mesh.positions[f[k]].x, mesh.positions[f[k]].y, mesh.positions[f[k]].z};
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        auto& flat = out.emplace_back();
        for (std::size_t k = 0; k < 9; ++k) flat[k] = corners[k / 3][k % 3];
    }
    std::sort(out.begin(), out.end());
    return out;
}

std::string position_accessor(int view, const Mesh& mesh, const std::string& more = {}) {
    return fmt::format(R"("bufferView":{},"componentType":5126,"count":{},"type":"VEC3"{})", view,
                       mesh.positions.size(), more);
}

Bytes draco_stream(const Mesh& mesh, bool sequential, bool metadata = false) {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(static_cast<int>(mesh.faces.size()));
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        std::array<std::array<float, 3>, 3> p{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& from = mesh.positions[mesh.faces[f][k]];
            p[k] = {static_cast<float>(from.x), static_cast<float>(from.y), static_cast<float>(from.z)};
        }
        builder.SetAttributeValuesForFace(position, draco::FaceIndex(f), &p[0], &p[1], &p[2]);
    }
    const std::unique_ptr<draco::Mesh> built = builder.Finalize();
    if (metadata) {
        auto all = std::make_unique<draco::GeometryMetadata>();
        all->AddEntryString("name", "sphere");
        built->AddMetadata(std::move(all));
    }
    draco::Encoder encoder;
    encoder.SetEncodingMethod(sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*built, &buffer).ok());
    const auto* begin = reinterpret_cast<const std::byte*>(buffer.data());
    return {begin, begin + buffer.size()};
}

/// As gltf-transform and draco_transcoder write it: accessors without views, no buffer but the stream's.
Gltf draco_gltf(const Mesh& mesh, ByteSpan stream) {
    Gltf gltf;
    const int view = gltf.add_view(stream);
    gltf.add_accessor(fmt::format(R"("componentType":5126,"count":{},"type":"VEC3")", mesh.positions.size()));
    gltf.add_accessor(fmt::format(R"("componentType":5123,"count":{},"type":"SCALAR")", 3 * mesh.faces.size()));
    gltf.primitive =
        fmt::format(R"("attributes":{{"POSITION":0}},"indices":1,"extensions":)"
                    R"({{"KHR_draco_mesh_compression":{{"bufferView":{},"attributes":{{"POSITION":0}}}}}})",
                    view);
    gltf.more = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])";
    return gltf;
}

TEST(PackedGltf, DracosPrimitivesAreRead) {
    const Mesh mesh = sample();
    for (const bool sequential : {false, true}) {
        for (const bool metadata : {false, true}) {
            const Gltf gltf = draco_gltf(mesh, draco_stream(mesh, sequential, metadata));
            const Result<Mesh> back = read(gltf.json());
            ASSERT_TRUE(back.ok()) << back.error().message;
            EXPECT_EQ(back->positions.size(), mesh.positions.size());
            EXPECT_EQ(triangles_of(*back), triangles_of(mesh));
            CleanReport report;
            const Result<Mesh> binary = read_mesh_from_memory(gltf.glb(), MeshFormat::Glb, report);
            ASSERT_TRUE(binary.ok()) << binary.error().message;
            EXPECT_EQ(triangles_of(*binary), triangles_of(mesh));
        }
    }
}

TEST(PackedGltf, DamagedDracoStreamsAreRefused) {
    const Mesh mesh = sample();
    const Bytes stream = draco_stream(mesh, false);
    const auto error_of = [&](const Bytes& bytes) {
        const Result<Mesh> back = read(draco_gltf(mesh, bytes).json());
        return back ? std::string("was read") : back.error().message;
    };
    const auto with = [&](std::size_t at, unsigned byte) {
        Bytes other = stream;
        other[at] = static_cast<std::byte>(byte);
        return other;
    };
    EXPECT_THAT(error_of(with(0, 'X')), HasSubstr("buffer view 0 holds no Draco stream"));
    EXPECT_THAT(error_of(with(5, 1)), HasSubstr("bitstream 2.2"));
    EXPECT_THAT(error_of(with(7, 0)), HasSubstr("no triangle mesh"));
    EXPECT_THAT(error_of(Bytes(stream.begin(), stream.begin() + 40)), HasSubstr("Draco"));
    Bytes huge(stream.begin(), stream.begin() + 12);  // up to the counts
    for (const unsigned b : {3u, 0xFFu, 0xFFu, 0xFFu, 0xFFu, 0x0Fu, 0u, 0u}) huge.push_back(static_cast<std::byte>(b));
    EXPECT_THAT(error_of(huge), HasSubstr("than its bytes can hold"));
    Gltf other_id = draco_gltf(mesh, stream);
    other_id.primitive.replace(other_id.primitive.find(R"("POSITION":0}}})"), 12, R"("POSITION":9)");
    const Result<Mesh> back = read(other_id.json());
    ASSERT_FALSE(back.ok());
    EXPECT_THAT(back.error().message, HasSubstr("has no POSITION in its Draco stream"));
}

/// Members of a view that meshopt's bytes unpack into; the buffer behind it is a fallback without data.
std::string meshopt_view(std::size_t at, std::size_t length, std::size_t count, std::size_t stride,
                         const std::string& mode, const std::string& filter = "NONE") {
    return fmt::format(
        R"("buffer":1,"byteLength":{},"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":{},)"
        R"("byteLength":{},"byteStride":{},"count":{},"mode":"{}","filter":"{}"}}}})",
        count * stride, at, length, stride, count, mode, filter);
}

struct MeshoptFile {
    std::string mode = "TRIANGLES", filter = "NONE";
    std::size_t rows_too_many = 0;
    std::size_t damaged_at = ~std::size_t{0};  // a byte that is changed
};

Gltf meshopt_gltf(const Mesh& mesh, const MeshoptFile& file) {
    const std::vector<std::uint32_t> corners = corners_of(mesh);
    const std::size_t count = mesh.positions.size();
    std::vector<unsigned char> rows(meshopt_encodeVertexBufferBound(count, 12));
    Bytes plain = floats_of(mesh);
    if (file.filter == "EXPONENTIAL") {
        const Bytes from = plain;
        meshopt_encodeFilterExp(plain.data(), count, 12, 16, reinterpret_cast<const float*>(from.data()));
    }
    rows.resize(meshopt_encodeVertexBuffer(rows.data(), rows.size(), plain.data(), count, 12));
    std::vector<unsigned char> packed(meshopt_encodeIndexBufferBound(corners.size(), count) +
                                      meshopt_encodeIndexSequenceBound(corners.size(), count));
    packed.resize(file.mode == "TRIANGLES"
                      ? meshopt_encodeIndexBuffer(packed.data(), packed.size(), corners.data(), corners.size())
                      : meshopt_encodeIndexSequence(packed.data(), packed.size(), corners.data(), corners.size()));
    if (file.damaged_at < rows.size()) rows[file.damaged_at] ^= 0xFFu;

    Gltf gltf;
    const ByteSpan row_bytes = std::as_bytes(std::span(rows)), corner_bytes = std::as_bytes(std::span(packed));
    gltf.data.assign(row_bytes.begin(), row_bytes.end());
    gltf.data.insert(gltf.data.end(), corner_bytes.begin(), corner_bytes.end());
    gltf.views = "{" + meshopt_view(0, rows.size(), count + file.rows_too_many, 12, "ATTRIBUTES", file.filter) + "},{" +
                 meshopt_view(rows.size(), packed.size(), corners.size(), 4, file.mode) + "}";
    gltf.more_buffers = R"(,{"byteLength":100000000,"extensions":{"EXT_meshopt_compression":{"fallback":true}}})";
    gltf.add_accessor(position_accessor(0, mesh));
    gltf.add_accessor(fmt::format(R"("bufferView":1,"componentType":5125,"count":{},"type":"SCALAR")", corners.size()));
    gltf.primitive = R"("attributes":{"POSITION":0},"indices":1)";
    gltf.more = R"(,"extensionsRequired":["EXT_meshopt_compression"])";
    return gltf;
}

TEST(PackedGltf, MeshoptsViewsAreRead) {
    const Mesh mesh = sample();
    for (const MeshoptFile& file :
         {MeshoptFile{}, MeshoptFile{"INDICES", "NONE"}, MeshoptFile{"TRIANGLES", "EXPONENTIAL"}}) {
        SCOPED_TRACE(file.mode + " " + file.filter);
        const Gltf gltf = meshopt_gltf(mesh, file);
        const Result<Mesh> back = read(gltf.json());
        ASSERT_TRUE(back.ok()) << back.error().message;
        EXPECT_EQ(triangles_of(*back), triangles_of(mesh));
        CleanReport report;
        const Result<Mesh> binary = read_mesh_from_memory(gltf.glb(), MeshFormat::Glb, report);
        ASSERT_TRUE(binary.ok()) << binary.error().message;
        EXPECT_EQ(triangles_of(*binary), triangles_of(mesh));
    }
}

TEST(PackedGltf, DamagedMeshoptViewsAreRefused) {
    const Mesh mesh = sample();
    const auto error_of = [&](const std::string& json) {
        const Result<Mesh> back = read(json);
        return back ? std::string("was read") : back.error().message;
    };
    EXPECT_THAT(error_of(meshopt_gltf(mesh, {.damaged_at = 0}).json()),
                HasSubstr("buffer view 0 is refused by meshopt"));
    EXPECT_THAT(error_of(meshopt_gltf(mesh, {.rows_too_many = 100'000'000}).json()),
                HasSubstr("more than its bytes can hold"));
    EXPECT_THAT(error_of(meshopt_gltf(mesh, {.mode = "POINTS"}).json()), HasSubstr("does not know"));
    EXPECT_THAT(error_of(meshopt_gltf(mesh, {.filter = "QUATERNION"}).json()), HasSubstr("does not know"));
    EXPECT_THAT(error_of(meshopt_gltf(mesh, {.filter = "COLOR"}).json()), HasSubstr("does not know"));
    std::string outside = meshopt_gltf(mesh, {}).json();
    outside.replace(outside.find(R"("byteOffset":0)"), 14, R"("byteOffset":99999999)");
    EXPECT_THAT(error_of(outside), HasSubstr("packed beyond its buffer"));
}

/// `mesh` with the positions of its first vertices given by a sparse accessor, over its own or over nothing.
Gltf sparse_gltf(const Mesh& mesh, const std::string& base, unsigned index_shift = 0) {
    ByteWriter places, values;
    for (unsigned v = 0; v < mesh.positions.size(); ++v) {
        places.u16(static_cast<std::uint16_t>(v + index_shift));
        for (const double x : {mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z})
            values.f32(static_cast<float>(x));
    }
    Gltf gltf;
    const std::vector<std::uint32_t> corners = corners_of(mesh);
    const int indices = gltf.add_view(std::as_bytes(std::span(corners)));
    gltf.add_view(Bytes(12 * mesh.positions.size(), std::byte{0x3F}));  // other positions
    const int at = gltf.add_view(places.view()), to = gltf.add_view(values.view());
    gltf.add_accessor(
        fmt::format(R"({}"componentType":5126,"count":{},"type":"VEC3","sparse":{{"count":{},)"
                    R"("indices":{{"bufferView":{},"componentType":5123}},"values":{{"bufferView":{}}}}})",
                    base, mesh.positions.size(), mesh.positions.size(), at, to));
    gltf.add_accessor(
        fmt::format(R"("bufferView":{},"componentType":5125,"count":{},"type":"SCALAR")", indices, corners.size()));
    gltf.primitive = R"("attributes":{"POSITION":0},"indices":1)";
    return gltf;
}

TEST(PackedGltf, SparseAccessorsAreRead) {
    const Mesh mesh = sample();
    // "normalized" says nothing of floats, nor of the changes' places.
    for (const std::string base : {"", R"("bufferView":1,)", R"("normalized":true,)"}) {
        const Result<Mesh> back = read(sparse_gltf(mesh, base).json());
        ASSERT_TRUE(back.ok()) << back.error().message;
        EXPECT_EQ(triangles_of(*back), triangles_of(mesh));
    }
    const Result<Mesh> outside = read(sparse_gltf(mesh, "", 1).json());
    ASSERT_FALSE(outside.ok());
    EXPECT_THAT(outside.error().message, HasSubstr("accessor 0 changes rows that it has not"));
    std::string huge = sparse_gltf(mesh, "").json();
    const std::string count = fmt::format(R"("count":{},"type":"VEC3")", mesh.positions.size());
    for (const char* many : {"4000000000", "9000000000000000000"}) {
        std::string json = huge;
        const Result<Mesh> refused =
            read(json.replace(json.find(count), count.size(), fmt::format(R"("count":{},"type":"VEC3")", many)));
        ASSERT_FALSE(refused.ok());
        EXPECT_THAT(refused.error().message, HasSubstr("more than its bytes can hold"));
    }
}

TEST(PackedGltf, QuantisedPositionsAreRead) {
    const Mesh mesh = sample();
    ByteWriter rows;  // each of 4 shorts, as KHR_mesh_quantization aligns them
    for (const Vec3& p : mesh.positions)
        for (const double x : {p.x, p.y, p.z, 0.0})
            rows.u16(std::bit_cast<std::uint16_t>(static_cast<std::int16_t>(x * 64)));
    const std::vector<std::uint32_t> corners = corners_of(mesh);
    Gltf gltf;
    gltf.add_view(rows.view(), R"(,"byteStride":8)");
    gltf.add_view(std::as_bytes(std::span(corners)));
    gltf.add_accessor(
        fmt::format(R"("bufferView":0,"componentType":5122,"count":{},"type":"VEC3")", mesh.positions.size()));
    gltf.add_accessor(fmt::format(R"("bufferView":1,"componentType":5125,"count":{},"type":"SCALAR")", corners.size()));
    gltf.primitive = R"("attributes":{"POSITION":0},"indices":1)";
    gltf.node = R"("mesh":0,"scale":[0.015625,0.015625,0.015625])";
    gltf.more = R"(,"extensionsRequired":["KHR_mesh_quantization"])";
    const Result<Mesh> back = read(gltf.json());
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(triangles_of(*back), triangles_of(mesh));
}

TEST(PackedGltf, InstancesAreAllThere) {
    const Mesh mesh = sample();
    const std::vector<std::uint32_t> corners = corners_of(mesh);
    ByteWriter shifts;
    for (const float x : {0.f, 0.f, 0.f, 10.f, 0.f, 0.f, 0.f, 20.f, 0.f}) shifts.f32(x);
    ByteWriter turns;  // the last by 90 degrees about z, in normalized shorts
    for (const int x : {0, 0, 0, 32767, 0, 0, 0, 32767, 0, 0, 23170, 23170}) turns.u16(static_cast<std::uint16_t>(x));
    Gltf gltf;
    gltf.add_view(floats_of(mesh));
    gltf.add_view(std::as_bytes(std::span(corners)));
    gltf.add_view(shifts.view());
    gltf.add_view(turns.view());
    gltf.add_accessor(position_accessor(0, mesh));
    gltf.add_accessor(fmt::format(R"("bufferView":1,"componentType":5125,"count":{},"type":"SCALAR")", corners.size()));
    gltf.add_accessor(R"("bufferView":2,"componentType":5126,"count":3,"type":"VEC3")");
    gltf.add_accessor(R"("bufferView":3,"componentType":5122,"normalized":true,"count":3,"type":"VEC4")");
    gltf.primitive = R"("attributes":{"POSITION":0},"indices":1)";
    const auto node = [](const std::string& attributes) {
        return R"("mesh":0,"translation":[0,0,5],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{)" +
               attributes + "}}}";
    };
    gltf.node = node(R"("TRANSLATION":2,"ROTATION":3)");
    const Result<Mesh> back = read(gltf.json());
    ASSERT_TRUE(back.ok()) << back.error().message;
    const std::size_t n = mesh.positions.size();
    ASSERT_EQ(back->positions.size(), 3 * n);
    for (std::size_t v = 0; v < n; ++v) {
        const Vec3& p = mesh.positions[v];
        EXPECT_LT(length(back->positions[v] - (p + Vec3{0, 0, 5})), 1e-12);
        EXPECT_LT(length(back->positions[n + v] - (p + Vec3{10, 0, 5})), 1e-12);
        EXPECT_LT(length(back->positions[2 * n + v] - Vec3{-p.y, 20 + p.x, p.z + 5}), 1e-4);
    }
    gltf.node = node(R"("TRANSLATION":2,"ROTATION":0)");
    EXPECT_FALSE(read(gltf.json()).ok()) << "as many turns as vertices";
    gltf.node = node("");
    EXPECT_FALSE(read(gltf.json()).ok()) << "no instance, no face";
}

/// Found by fuzzing: up to 8 bytes behind the file were read.
TEST(PackedGltf, BinaryChunksThatEndBehindTheFileAreRefused) {
    const Mesh mesh = sample();
    Bytes file = meshopt_gltf(mesh, {}).glb();
    ByteReader head(ByteSpan(file).subspan(12));
    const std::size_t at = 20 + head.u32();  // of the binary chunk's length
    for (const unsigned more : {4u, 8u}) {
        Bytes longer = file;
        longer[at] = static_cast<std::byte>(std::to_integer<unsigned>(file[at]) + more);
        CleanReport report;
        const Result<Mesh> back = read_mesh_from_memory(longer, MeshFormat::Glb, report);
        ASSERT_FALSE(back.ok()) << more;
        EXPECT_THAT(back.error().message, HasSubstr("binary chunk is cut"));
    }
}

TEST(PackedGltf, FilesAsToolsWriteThemAreRead) {
    for (const std::string name : {"packed_draco.glb", "packed_meshopt.glb"}) {
        CleanReport report;
        const Result<Mesh> back = read_mesh(test_data_folder() + "/" + name, report);
        ASSERT_TRUE(back.ok()) << back.error().message;
        ASSERT_EQ(back->positions.size(), sample().positions.size()) << name;
        const auto got = triangles_of(*back), wanted = triangles_of(sample());
        ASSERT_EQ(got.size(), wanted.size());
        Vec3 sums;  // over all corners: gltfpack rounds to 14 bits, which may change the order of triangles
        for (std::size_t f = 0; f < got.size(); ++f)
            for (std::size_t k = 0; k < 9; k += 3)
                sums += Vec3{std::abs(got[f][k]) - std::abs(wanted[f][k]),
                             std::abs(got[f][k + 1]) - std::abs(wanted[f][k + 1]),
                             std::abs(got[f][k + 2]) - std::abs(wanted[f][k + 2])};
        EXPECT_LT(length(sums) / static_cast<double>(got.size()), 1e-4) << name;
        for (const Vec3& p : back->positions) EXPECT_NEAR(length(p), 1.0, 0.015) << name;
    }
}

}  // namespace
}  // namespace mvw
