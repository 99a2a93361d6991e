// STL, ASCII and binary: triangles without indices.
//
// An own reader: OpenMesh welds by a tolerance of its own while it reads, so vertex counts come out changed, and assimp
// rounds ASCII numbers its own way to float32. clean() welds, bit-equal positions only.
#include <fmt/format.h>

#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/text.h"

namespace mvw {
namespace {

constexpr std::size_t kHeadBytes = 84, kFacetBytes = 50;

/// Binary files may begin with "solid" too, so the size decides: it follows from the count at byte 80.
bool has_binary_size(ByteSpan bytes) {
    if (bytes.size() < kHeadBytes) return false;
    ByteReader in(bytes.subspan(80));
    return bytes.size() == kHeadBytes + kFacetBytes * std::uint64_t{in.u32()};
}

bool equals_any_case(std::string_view word, std::string_view lower) {
    return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                      [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a + ('a' - 'A') : a) == b; });
}

Result<Polygons> read_binary(ByteSpan bytes) {
    if (bytes.size() < kHeadBytes) return Error{Errc::Malformed, bytes.size(), "is too short for an STL"};
    ByteReader in(bytes.subspan(80));
    const std::uint64_t count = in.u32();
    if (in.remaining() < count * kFacetBytes)
        return Error{Errc::Malformed, bytes.size(),
                     fmt::format("is truncated: {} triangles take {} bytes, there are {}", count,
                                 kHeadBytes + count * kFacetBytes, bytes.size())};
    Polygons out;
    out.positions.reserve(3 * count);
    out.corners.reserve(3 * count);
    out.starts.reserve(count + 1);
    for (std::uint64_t t = 0; t < count; ++t) {
        in.bytes(12);  // normal: recomputed by whoever needs it
        for (int k = 0; k < 3; ++k) {
            out.corners.push_back(static_cast<std::uint32_t>(out.positions.size()));
            const double x = in.f32(), y = in.f32(), z = in.f32();
            out.positions.push_back({x, y, z});
        }
        in.bytes(2);
        out.end_polygon();
    }
    return out;
}

Result<Polygons> read_ascii(std::string_view text) {
    Polygons out;
    Lines lines(text);
    const auto malformed = [&](const char* reason) {
        return Error{Errc::Malformed, 0, fmt::format("line {}: {}", lines.number(), reason)};
    };
    bool in_loop = false, ended = false;
    for (std::string_view line = lines.next(); !line.empty(); line = lines.next()) {
        const std::string_view word = next_word(line);
        if (equals_any_case(word, "outer")) {
            if (in_loop) return malformed("a loop begins inside another");
            in_loop = true;
        } else if (equals_any_case(word, "vertex")) {
            if (!in_loop) return malformed("a vertex outside of a loop");
            const auto x = to_number(next_word(line)), y = to_number(next_word(line)), z = to_number(next_word(line));
            if (!x || !y || !z) return malformed("a vertex needs three coordinates");
            out.corners.push_back(static_cast<std::uint32_t>(out.positions.size()));
            out.positions.push_back({*x, *y, *z});
        } else if (equals_any_case(word, "endloop")) {
            if (!in_loop) return malformed("a loop ends that did not begin");
            out.end_polygon();
            in_loop = false;
        }
        ended = equals_any_case(word, "endsolid");
    }
    if (!ended) return malformed("is truncated: no endsolid");
    return out;
}

}  // namespace

Result<Polygons> read_stl(ByteSpan bytes) {
    std::string_view text = as_text(bytes);
    if (has_binary_size(bytes)) return read_binary(bytes);
    std::string_view start = text;
    return equals_any_case(next_word(start), "solid") ? read_ascii(text) : read_binary(bytes);
}

Bytes write_stl(const Mesh& mesh) {
    ByteWriter out;
    for (int i = 0; i < 20; ++i) out.u32(0);
    out.u32(static_cast<std::uint32_t>(mesh.faces.size()));
    const auto write = [&](const Vec3& v) {
        const Vec3f p = to_float(v);
        out.f32(p.x);
        out.f32(p.y);
        out.f32(p.z);
    };
    for (const Face& f : mesh.faces) {
        const Vec3 &a = mesh.positions[f[0]], &b = mesh.positions[f[1]], &c = mesh.positions[f[2]];
        write(normalized(cross(b - a, c - a)));
        for (const Vec3* p : {&a, &b, &c}) write(*p);
        out.u16(0);
    }
    return out.take();
}

}  // namespace mvw
