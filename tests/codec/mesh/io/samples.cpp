#include "tests/codec/mesh/io/samples.h"

#include <algorithm>

#include "tests/support/archive.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

Bytes bytes_of(const std::string& text) {
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
}

Sample text(std::string name, MeshFormat format, const std::string& content, std::size_t vertices, std::size_t faces,
            std::optional<Rgba8> color = {}) {
    return {std::move(name), format, bytes_of(content), vertices, faces, color};
}

BadSample bad(MeshFormat format, const std::string& name, const std::string& content, const std::string& reason) {
    return {{name, format, bytes_of(content), 0, 0, {}}, reason};
}

Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

Bytes reversed(Bytes bytes, std::size_t from, std::size_t size) {
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(from);
    std::reverse(begin, begin + static_cast<std::ptrdiff_t>(size));
    return bytes;
}

std::string ply_head(const std::string& format, const std::string& vertices, const std::string& faces,
                     const std::string& more = {}) {
    return "ply\nformat " + format + " 1.0\ncomment made for tests\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\n" + more + "element face " + faces +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}

const std::string kColorProperties = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

/// A triangle in big-endian bytes.
Bytes big_endian_ply() {
    Bytes body = floats({0, 0, 0, 1, 0, 0, 0, 1, 0});
    for (std::size_t i = 0; i < body.size(); i += 4) body = reversed(body, i, 4);
    return bytes_of(ply_head("binary_big_endian", "3", "1")) + body +
           bytes_of(std::string("\3\0\0\0\0\0\0\0\1\0\0\0\2", 13));
}

/// Lists before and behind what matters, counted by 32 bits, and doubles.
Bytes ply_with_extras() {
    ByteWriter out;
    const std::string head =
        "ply\r\nformat binary_little_endian 1.0\r\nelement junk 2\r\nproperty list uint short a\r\nproperty char b\r\n"
        "element vertex 3\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\nproperty float "
        "confidence\r\n"
        "element face 1\r\nproperty uchar flag\r\nproperty list uint uint vertex_index\r\nend_header\r\n";
    out.bytes(bytes_of(head));
    out.u32(2), out.u16(1), out.u16(2), out.u8(1), out.u32(0), out.u8(1);
    for (const double value : {0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0}) {
        out.f64(value);
        if (out.size() % 28 == (head.size() + 14 + 24) % 28) out.f32(0.5f);
    }
    out.u8(9), out.u32(3), out.u32(0), out.u32(1), out.u32(2);
    return out.take();
}

Bytes binary_stl(std::uint32_t claimed, std::uint32_t triangles, const char* start) {
    ByteWriter out;
    std::string head = start;
    head.resize(80, ' ');
    out.bytes(bytes_of(head));
    out.u32(claimed);
    for (std::uint32_t t = 0; t < triangles; ++t) {
        out.bytes(floats({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, static_cast<float>(t)}));
        out.u16(0);
    }
    return out.take();
}

const std::string kFacet =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1e0 +0.5\n endloop\nendfacet\n";

Sample glb() {
    Mesh cube = unit_cube();
    for (std::uint8_t v = 0; v < 8; ++v) cube.colors.push_back({v, static_cast<std::uint8_t>(100 + v), 255, 128});
    for (std::uint32_t f = 0; f < 12; ++f) cube.materials.push_back(f / 6);
    return {"cube.glb", MeshFormat::Glb,        write_mesh_to_memory(cube, MeshFormat::Glb).value(), 8,
            12,         Rgba8{1, 101, 255, 128}};
}

/// The glTF triangle with one piece of its JSON replaced.
std::string gltf_with(const std::string& what, const std::string& by) {
    const Bytes bytes = gltf_triangle().bytes;
    std::string json(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t at = json.find(what);
    return at == std::string::npos ? std::string() : json.replace(at, what.size(), by);
}

std::vector<BadSample> bad_text_samples() {
    const MeshFormat off = MeshFormat::Off, obj = MeshFormat::Obj, stl = MeshFormat::Stl;
    return {
        bad(off, "wrong start", "OOF\n3 1 0\n", "does not begin with OFF"),
        bad(off, "no counts", "OFF\n", "numbers of vertices and faces are missing"),
        bad(off, "four coordinates", "4OFF\n1 1 0\n0 0 0 0\n", "only three coordinates"),
        bad(off, "huge counts", "OFF\n4000000000 4000000000 0\n0 0 0\n", "ends before the last vertex"),
        bad(off, "huge polygon", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n", "fewer corners than it says"),
        bad(off, "short vertex", "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n",
            "line 4: a vertex needs three coordinates"),
        bad(off, "NaN", "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
            "vertex 1 has a coordinate that is not a finite"),
        bad(off, "overflow", "OFF\n3 1 0\n0 0 0\n1 1e999 0\n0 1 0\n3 0 1 2\n", "not a finite"),
        bad(off, "index", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "face 0 names vertex 3 of 3"),
        bad(off, "negative index", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "face 0 has an index out of range"),
        bad(off, "no face", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "has no faces"),
        bad(off, "line faces only", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "has no faces"),
        bad(off, "no colour", "COFF\n1 0 0\n0 0 0\n", "needs a colour"),
        bad(obj, "NaN", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "line 2: 'nan' is not a finite number"),
        bad(obj, "word", "v 0 0 zero\n", "line 1: 'zero' is not a finite number"),
        bad(obj, "short vertex", "v 0 0\n", "line 1: a vertex needs three coordinates"),
        bad(obj, "index", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "face 0 names vertex 3 of 3"),
        bad(obj, "index 0", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "face 0 has an index out of range"),
        bad(obj, "too far back", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n", "face 0 has an index out of range"),
        bad(obj, "no face", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n", "has no faces"),
        bad(obj, "binary", std::string("\0\1\2\3\xFF", 5), "has no faces"),
        bad(stl, "too short", "hello", "too short for an STL"),
        bad(stl, "no end", "solid a\n" + kFacet, "truncated"),
        bad(stl, "no triangles", "solid a\nendsolid a\n", "has no faces"),
        bad(stl, "short vertex", "solid\nfacet\nouter loop\nvertex 1 2\n", "line 4: a vertex needs three coordinates"),
        bad(stl, "vertex outside", "solid\nvertex 1 2 3\n", "outside of a loop"),
        bad(stl, "NaN", "solid\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 nan 0\nendloop\nendsolid\n",
            "not a finite"),
    };
}

std::vector<BadSample> bad_binary_samples() {
    const MeshFormat ply = MeshFormat::Ply, gltf = MeshFormat::Gltf, glb_format = MeshFormat::Glb;
    const std::string triangle = "0 0 0\n1 0 0\n0 1 0\n";
    std::string deep = R"({"asset":{"version":"2.0"},"buffers":[],"extras":)" + std::string(100000, '[');
    std::vector<BadSample> samples{
        bad(ply, "wrong start", "plyx\n", "does not begin with ply"),
        bad(ply, "no end of header", "ply\nformat ascii 1.0\n", "no end_header"),
        bad(ply, "no format", "ply\nelement vertex 1\nend_header\n", "names no known format"),
        bad(ply, "bad type", "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n", "unknown type"),
        bad(ply, "negative count", "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "wrong count"),
        bad(ply, "no coordinates", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
            "no x, y and z"),
        bad(ply, "huge count", ply_head("binary_little_endian", "1000000000", "1"), "do not fit into its bytes"),
        bad(ply, "huge count in text", ply_head("ascii", "4000000000", "1") + triangle, "do not fit into its bytes"),
        bad(ply, "huge list", ply_head("ascii", "3", "1") + triangle + "4000000000 0 1 2\n",
            "damaged at row 0 of element face"),
        bad(ply, "word", ply_head("ascii", "3", "1") + "0 0 0\n1 abc 0\n0 1 0\n3 0 1 2\n",
            "damaged at row 1 of element vertex"),
        bad(ply, "NaN", ply_head("ascii", "3", "1") + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "vertex 1 has a coordinate"),
        bad(ply, "index", ply_head("ascii", "3", "1") + triangle + "3 0 1 3\n", "face 0 names vertex 3 of 3"),
        bad(ply, "negative index", ply_head("ascii", "3", "1") + triangle + "3 0 1 -1\n", "index out of range"),
        bad(ply, "no face", ply_head("ascii", "3", "0") + triangle, "has no faces"),
        {{"STL count", MeshFormat::Stl, binary_stl(1u << 30, 1, ""), 0, 0, {}}, "is truncated"},
        {{"STL without triangles", MeshFormat::Stl, binary_stl(0, 0, ""), 0, 0, {}}, "has no faces"},
        bad(gltf, "no JSON", "{\"asset\":", "its JSON is damaged"),
        bad(gltf, "a list", "[]", "its JSON is damaged"),
        bad(gltf, "no meshes", R"({"asset":{"version":"2.0"}})", "has no faces"),
        bad(gltf, "deep", deep, "nests its JSON too deep"),
        bad(gltf, "count", gltf_with(R"("count":3)", R"("count":1000000000)"), "reaches beyond its buffer"),
        bad(gltf, "offset", gltf_with(R"("byteOffset":0)", R"("byteOffset":18446744073709551615)"),
            "reaches beyond its buffer"),
        bad(gltf, "accessor", gltf_with(R"("POSITION":0)", R"("POSITION":7)"), "no accessor 7"),
        bad(gltf, "node", gltf_with(R"("nodes":[0])", R"("nodes":[5])"), "no node 5"),
        bad(gltf, "mesh", gltf_with(R"({"mesh":0})", R"({"mesh":3})"), "no mesh 3"),
        bad(gltf, "points", gltf_with(R"("attributes")", R"("mode":0,"attributes")"), "has no faces"),
        bad(gltf, "extension", gltf_with(R"("meshes")", R"("extensionsRequired":["KHR_meshopt_compression"],"meshes")"),
            "needs the extension KHR_meshopt_compression"),
        bad(gltf, "old", gltf_with(R"("2.0")", R"("1.0")"), "is glTF 1.0: only 2.0 is known"),
        bad(glb_format, "too short", "glTF", "glTF"),
    };
    return samples;
}

}  // namespace

Bytes floats(std::initializer_list<float> values) {
    ByteWriter out;
    for (const float value : values) out.f32(value);
    return out.take();
}

Sample obj(const std::string& content) {
    return text("literal.obj", MeshFormat::Obj, content, 0, 0);
}

Sample gltf_triangle(const std::string& uri, const std::string& scene) {
    const std::string inside = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    return text("triangle.gltf", MeshFormat::Gltf,
                R"({"asset":{"version":"2.0"},)" + scene +
                    R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
                    R"("accessors":[{"bufferView":0,"byteOffset":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
                    R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":")" +
                    (uri.empty() ? inside : uri) + R"("}]})",
                3, 1);
}

std::vector<Sample> good_samples() {
    const Rgba8 color{1, 2, 3, 255};
    std::vector<Sample> samples{
        text("plain.off", MeshFormat::Off,
             "OFF\n# a comment\n4 2 0\n\n0 0 0\n1 0 0 # another\n0 1 0\n+1 1.0e0 .5\n3 0 1 2\n3 1 3 2 0 255 0\n", 4, 2),
        text("one_line.off", MeshFormat::Off, "OFF 3 1 0\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2", 3, 1),
        text("no_keyword.off", MeshFormat::Off, "# a comment\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", 3, 1),
        text("bytes.coff", MeshFormat::Off, "COFF\n3 1 0\n0 0 0 9 9 9 9\n1 0 0 1 2 3\n0 1 0 9 9 9 9\n3 0 1 2\n", 3, 1,
             color),
        text("fractions.coff", MeshFormat::Off,
             "CNOFF\n3 1 0\n0 0 0 0 0 1 1 1 1 1\n1 0 0 0 0 1 1. .5 0 1\n0 1 0 0 0 1 0 0 0 1\n3 0 1 2\n", 3, 1,
             Rgba8{255, 128, 0, 255}),
        text("octagon.off", MeshFormat::Off, "OFF\n5 1 0\n0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 2 0\n5 0 1 2 3 4\n", 5, 3),
        text("plain.obj", MeshFormat::Obj,
             "# c\no thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ns off\nf 1 2 3 4\nf 1 2\n", 4, 2),
        text("colors.obj", MeshFormat::Obj, "v 0 0 0 1 1 1\nv 1 0 0 0 0.5 1\nv 0 1 0 0 0 0\nf 1 2 3", 3, 1,
             Rgba8{0, 128, 255, 255}),
        text("ascii.ply", MeshFormat::Ply,
             ply_head("ascii", "4", "2", kColorProperties) +
                 "0 0 0 0 0 0\n1 0 0 1 2 3\n0 1 0 9 9 9\n1 1 0 9 9 9\n3 0 1 2\n3 1 3 2\n",
             4, 2, color),
        text("quad.ply", MeshFormat::Ply, ply_head("ascii", "4", "1") + "0 0 0 1 0 0 1 1 0 0 1 0 4 0 1 2 3", 4, 2),
        {"big_endian.ply", MeshFormat::Ply, big_endian_ply(), 3, 1, {}},
        {"extras.ply", MeshFormat::Ply, ply_with_extras(), 3, 1, {}},
        text("ascii.stl", MeshFormat::Stl, "SOLID a b c\n" + kFacet + kFacet + "endsolid a\n", 6, 2),
        {"binary.stl", MeshFormat::Stl, binary_stl(2, 2, "binary"), 6, 2, {}},
        {"solid.stl", MeshFormat::Stl, binary_stl(2, 2, "solid says the start of this binary file"), 6, 2, {}},
        gltf_triangle(),
        glb(),
        {"triangle.3mf",
         MeshFormat::ThreeMf,
         threemf_of(R"(<model><resources><object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/>)"
                    R"(<vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices><triangles>)"
                    R"(<triangle v1="0" v2="1" v3="2"/></triangles></mesh></object></resources>)"
                    R"(<build><item objectid="1"/></build></model>)"),
         3,
         1,
         {}},
    };
    return samples;
}

std::vector<BadSample> bad_samples() {
    std::vector<BadSample> samples = bad_text_samples();
    for (BadSample& sample : bad_binary_samples()) samples.push_back(std::move(sample));
    return samples;
}

}  // namespace mvw
