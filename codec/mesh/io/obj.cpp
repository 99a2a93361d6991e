// Wavefront OBJ: tinyobjloader finds vertices, faces and materials; texture and normal indices are left out, so that
// seams stay closed.
#include <fmt/format.h>

#include <exception>
#include <istream>
#include <iterator>
#include <map>
#include <streambuf>

#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/text.h"

// Compiled here for real_t = double: the shared library is built for float.
#define TINYOBJLOADER_USE_DOUBLE
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

namespace mvw {
namespace {

/// A stream over bytes that stay where they are.
class MemoryBuffer : public std::streambuf {
 public:
    explicit MemoryBuffer(ByteSpan bytes) {
        char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));  // read only: no put area is set
        setg(begin, begin, begin + bytes.size());
    }
};

/// What tinyobjloader's callbacks gather.
struct Gathered {
    Polygons polygons;
    std::map<std::string, std::uint32_t> labels;  // of material names, by first use
    std::uint32_t label = 0;
};

/// OBJ counts from 1, or from -1 back from the vertex given last.
std::uint32_t to_index(int raw, std::size_t vertices) {
    if (raw > 0) return static_cast<std::uint32_t>(raw - 1);
    const std::int64_t back = static_cast<std::int64_t>(vertices) + raw;
    return raw < 0 && back >= 0 ? static_cast<std::uint32_t>(back) : kBadIndex;
}

tinyobj::callback_t callbacks() {
    tinyobj::callback_t to;
    to.vertex_cb = [](void* data, double x, double y, double z, double) {
        static_cast<Gathered*>(data)->polygons.positions.push_back({x, y, z});
    };
    to.index_cb = [](void* data, tinyobj::index_t* indices, int count) {
        auto& [polygons, labels, label] = *static_cast<Gathered*>(data);
        for (int i = 0; i < count; ++i)
            polygons.corners.push_back(to_index(indices[i].vertex_index, polygons.positions.size()));
        polygons.end_polygon();
        polygons.materials.push_back(label);
    };
    to.usemtl_cb = [](void* data, const char* name, int) {
        auto& [polygons, labels, label] = *static_cast<Gathered*>(data);
        // 0 is for faces before the first usemtl.
        label = labels.emplace(name, static_cast<std::uint32_t>(labels.size()) + 1).first->second;
    };
    return to;
}

/// tinyobjloader takes what is no number for 0 and leaves out the colours that many scanners put behind coordinates
/// (v x y z r g b, fractions of 1): this pass refuses the one and gathers the other.
Result<void> check_vertex_lines(std::string_view text, std::vector<Rgba8>& colors) {
    bool colored = true;
    for (std::size_t number = 1; !text.empty(); ++number) {
        std::string_view line = next_line(text);
        if (next_word(line) != "v") continue;
        double value[7] = {};
        std::size_t n = 0;
        for (std::string_view word = next_word(line); !word.empty() && n < 7; word = next_word(line), ++n) {
            const auto parsed = to_number(word);
            if (!parsed && n >= 3) break;
            if (!parsed || !std::isfinite(*parsed))
                return Error{Errc::Malformed, 0, fmt::format("line {}: '{}' is not a finite number", number, word)};
            value[n] = *parsed;
        }
        if (n < 3) return Error{Errc::Malformed, 0, fmt::format("line {}: a vertex needs three coordinates", number)};
        colored = colored && n == 6;
        if (!colored) continue;
        const auto channel = [&](double v) {
            return static_cast<std::uint8_t>(std::lround(255 * std::min(std::max(v, 0.0), 1.0)));
        };
        colors.push_back({channel(value[3]), channel(value[4]), channel(value[5]), 255});
    }
    if (!colored) colors.clear();
    return {};
}

}  // namespace

Result<Polygons> read_obj(ByteSpan bytes) {
    Gathered gathered;
    const Result<void> fine = check_vertex_lines(as_text(bytes), gathered.polygons.colors);
    if (!fine) return fine.error();
    MemoryBuffer buffer(bytes);
    std::istream stream(&buffer);
    std::string warning, error;
    try {
        if (!tinyobj::LoadObjWithCallback(stream, callbacks(), &gathered, nullptr, &warning, &error))
            return Error{Errc::Malformed, 0, "is no OBJ: " + error};
    } catch (const std::exception& failure) {
        return Error{Errc::Malformed, 0, std::string("is no OBJ: ") + failure.what()};
    }
    return std::move(gathered.polygons);
}

Bytes write_obj(const Mesh& mesh) {
    fmt::memory_buffer text;
    const auto out = std::back_inserter(text);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3& p = mesh.positions[v];
        fmt::format_to(out, "v {} {} {}", p.x, p.y, p.z);
        if (!mesh.colors.empty()) {
            const Rgba8& c = mesh.colors[v];
            fmt::format_to(out, " {:.4f} {:.4f} {:.4f}", c.r / 255.0, c.g / 255.0, c.b / 255.0);
        }
        text.push_back('\n');
    }
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        if (!mesh.materials.empty() && (f == 0 || mesh.materials[f] != mesh.materials[f - 1]))
            fmt::format_to(out, "usemtl material_{}\n", mesh.materials[f]);
        fmt::format_to(out, "f {} {} {}\n", mesh.faces[f][0] + 1, mesh.faces[f][1] + 1, mesh.faces[f][2] + 1);
    }
    const ByteSpan written = as_bytes({text.data(), text.size()});
    return {written.begin(), written.end()};
}

}  // namespace mvw
