// OFF of Geomview, ASCII: [ST][C][N]OFF, which may be left out, counts, vertices, faces.
//
// An own reader: OpenMesh and assimp, the libraries at hand, pass OFF coordinates on as float32. Of
// 1000000.01 that keeps 1000000, and a model of size 0.02 there becomes a point.
#include <fmt/format.h>

#include <iterator>

#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/text.h"

namespace mvw {
namespace {

struct OffHeader {
    bool normals = false, colors = false;
    std::uint64_t vertices = 0, faces = 0;
};

Error at_line(const Lines& lines, const char* reason) {
    return {Errc::Malformed, 0, fmt::format("line {}: {}", lines.number(), reason)};
}

/// A count or index: a whole number below 2^32.
std::optional<std::uint32_t> to_index(std::string_view word) {
    const std::optional<double> value = to_number(word);
    if (!value || !(*value >= 0) || *value >= 4294967295.0 || *value != std::floor(*value)) return {};
    return static_cast<std::uint32_t>(*value);
}

/// [ST][C][N]OFF
Result<void> read_keyword(std::string_view word, OffHeader& header) {
    for (std::string_view prefix = word.substr(0, word.size() - 3); !prefix.empty();) {
        if (prefix.substr(0, 2) == "ST") {
            prefix.remove_prefix(2);
            continue;
        }
        header.colors = header.colors || prefix[0] == 'C';
        header.normals = header.normals || prefix[0] == 'N';
        if (prefix[0] != 'C' && prefix[0] != 'N')
            return Error{Errc::Unsupported, 0, fmt::format("is {}: only three coordinates are known", word)};
        prefix.remove_prefix(1);
    }
    return {};
}

Result<OffHeader> read_header(Lines& lines) {
    OffHeader header;
    std::string_view line = lines.next();
    std::string_view word = next_word(line);
    if (word.ends_with("OFF")) {
        if (const auto known = read_keyword(word, header); !known) return known.error();
        word = next_word(line);
        if (word == "BINARY") return Error{Errc::Unsupported, 0, "is binary OFF, which is not known"};
        if (word.empty()) {
            line = lines.next();
            word = next_word(line);
        }
    } else if (!to_index(word)) {
        return at_line(lines, "does not begin with OFF");
    }
    const auto vertices = to_index(word), faces = to_index(next_word(line));
    if (!vertices || !faces) return at_line(lines, "the numbers of vertices and faces are missing");
    header.vertices = *vertices;
    header.faces = *faces;
    return header;
}

/// Three or four values, either whole numbers to 255 or fractions of 1.
std::optional<Rgba8> to_color(std::string_view words) {
    double value[4] = {0, 0, 0, 0};
    std::size_t n = 0;
    bool fraction = false;
    for (std::string_view word = next_word(words); !word.empty() && n < 4; word = next_word(words), ++n) {
        const std::optional<double> number = to_number(word);
        if (!number || !(*number >= 0)) return {};
        fraction = fraction || word.find_first_of(".eE") != std::string_view::npos;
        value[n] = *number;
    }
    if (n < 3) return {};
    const auto channel = [&](double v) {
        return static_cast<std::uint8_t>(std::lround(std::min(fraction ? v * 255 : v, 255.0)));
    };
    return Rgba8{channel(value[0]), channel(value[1]), channel(value[2]),
                 n > 3 ? channel(value[3]) : std::uint8_t{255}};
}

Result<void> read_vertex(Lines& lines, const OffHeader& header, Polygons& out) {
    std::string_view line = lines.next();
    if (line.empty()) return at_line(lines, "ends before the last vertex");
    Vec3 p;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::optional<double> value = to_number(next_word(line));
        if (!value) return at_line(lines, "a vertex needs three coordinates");
        p[k] = *value;
    }
    out.positions.push_back(p);
    if (!header.colors) return {};
    for (int k = 0; header.normals && k < 3; ++k) next_word(line);
    const std::optional<Rgba8> color = to_color(line);
    if (!color) return at_line(lines, "a vertex of COFF needs a colour");
    out.colors.push_back(*color);
    return {};
}

Result<void> read_face(Lines& lines, Polygons& out) {
    std::string_view line = lines.next();
    if (line.empty()) return at_line(lines, "ends before the last face");
    const auto corners = to_index(next_word(line));
    if (!corners) return at_line(lines, "a face needs its number of corners");
    for (std::uint32_t k = 0; k < *corners; ++k) {
        const std::string_view word = next_word(line);
        if (word.empty()) return at_line(lines, "a face has fewer corners than it says");
        out.corners.push_back(to_index(word).value_or(kBadIndex));
    }
    out.end_polygon();
    return {};
}

}  // namespace

Result<Polygons> read_off(ByteSpan bytes) {
    Lines lines(as_text(bytes));
    const Result<OffHeader> header = read_header(lines);
    if (!header) return header.error();
    // The shortest vertex takes 6 bytes, the shortest face 2: larger counts cannot be true and reserve nothing.
    Polygons out;
    out.positions.reserve(std::min<std::uint64_t>(header->vertices, lines.remaining() / 6 + 1));
    out.starts.reserve(std::min<std::uint64_t>(header->faces, lines.remaining() / 2) + 1);
    for (std::uint64_t v = 0; v < header->vertices; ++v)
        if (const Result<void> done = read_vertex(lines, *header, out); !done) return done.error();
    for (std::uint64_t f = 0; f < header->faces; ++f)
        if (const Result<void> done = read_face(lines, out); !done) return done.error();
    return out;
}

Bytes write_off(const Mesh& mesh) {
    fmt::memory_buffer text;
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "{}\n{} {} 0\n", mesh.colors.empty() ? "OFF" : "COFF", mesh.positions.size(),
                   mesh.faces.size());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3& p = mesh.positions[v];
        fmt::format_to(out, "{} {} {}", p.x, p.y, p.z);
        if (!mesh.colors.empty()) {
            const Rgba8& c = mesh.colors[v];
            fmt::format_to(out, " {} {} {} {}", c.r, c.g, c.b, c.a);
        }
        text.push_back('\n');
    }
    for (const Face& f : mesh.faces) fmt::format_to(out, "3 {} {} {}\n", f[0], f[1], f[2]);
    const ByteSpan written = as_bytes({text.data(), text.size()});
    return {written.begin(), written.end()};
}

}  // namespace mvw
