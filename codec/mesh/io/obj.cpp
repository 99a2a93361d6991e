// Wavefront OBJ: tinyobjloader finds vertices, faces and materials. Corners of one vertex with texture coordinates or
// normals of their own stay one vertex, so that seams stay closed: it gets the mean of their colours and normals.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <exception>
#include <istream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <streambuf>

#include "codec/mesh/io/files.h"
#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/paint.h"
#include "codec/mesh/io/text.h"
#include "codec/mesh/srgb.h"

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

/// Reads material libraries and their images from the mesh's folder; those that cannot be read are named, no error.
class PaintReader : public tinyobj::MaterialReader {
 public:
    PaintReader(const Surroundings& around, std::vector<std::string>& missing) : around_(around), missing_(missing) {}

    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                    std::map<std::string, int>* numbers, std::string* warning, std::string* error) override {
        const Result<Bytes> file = read_file_below(around_.folder, name);
        if (!file && around_.folder != nullptr) missing_.push_back(file.error().message);
        if (!file) return false;
        MemoryBuffer buffer(*file);
        std::istream stream(&buffer);
        const std::size_t first = materials->size();
        tinyobj::LoadMtl(numbers, materials, &stream, warning, error);
        const std::set<std::string> with_color = materials_with_color(as_text(*file));
        for (std::size_t m = first; m < materials->size(); ++m)
            paints_.emplace((*materials)[m].name, paint_of((*materials)[m], with_color.contains((*materials)[m].name)));
        return true;
    }
    /// By material name.
    [[nodiscard]] const std::map<std::string, Paint>& paints() const { return paints_; }

 private:
    /// tinyobjloader gives textured materials without a colour (Kd) a grey one.
    static std::set<std::string> materials_with_color(std::string_view text) {
        std::set<std::string> names;
        std::string_view name;
        for (Lines lines(text); lines.remaining() > 0;) {
            std::string_view line = lines.next();
            const std::string_view word = next_word(line);
            if (word == "newmtl") name = next_word(line);
            if (word == "Kd") names.emplace(name);
        }
        return names;
    }
    Paint paint_of(const tinyobj::material_t& material, bool has_color) {
        Paint paint;
        const auto& kd = material.diffuse;
        // Black would leave nothing of an image, so it is not meant.
        if (has_color && (material.diffuse_texname.empty() || kd[0] + kd[1] + kd[2] > 0))
            for (std::size_t k = 0; k < 3; ++k) paint.color[k] = to_linear(std::clamp(double{kd[k]}, 0.0, 1.0));
        if (material.diffuse_texname.empty()) return paint;
        paint.texture = texture_of(material.diffuse_texname);
        const tinyobj::texture_option_t& option = material.diffuse_texopt;
        if (option.clamp) paint.across = paint.down = Texture::Wrap::Clamp;
        // v runs upwards.
        paint.place = {{{option.scale[0], 0, option.origin_offset[0]},
                        {0, -double{option.scale[1]}, 1 - double{option.origin_offset[1]}}}};
        return paint;
    }
    std::shared_ptr<const Texture> texture_of(const std::string& name) {
        const auto decode = [&] {
            const Result<Bytes> file = read_file_below(around_.folder, name);
            return file ? Texture::decode(*file) : Result<Texture>(file.error());
        };
        return textures_.get(name, name, decode, missing_);
    }

    const Surroundings& around_;
    std::vector<std::string>& missing_;
    Textures<std::string> textures_;
    std::map<std::string, Paint> paints_;
};

/// What tinyobjloader's callbacks gather.
struct Gathered {
    Polygons polygons;
    std::map<std::string, std::uint32_t> labels;  // of material names, by first use
    std::uint32_t label = 0;
    std::vector<std::array<float, 2>> coordinates;  // of textures
    std::vector<Vec3> normals;
    std::vector<std::uint32_t> corner_coordinate, corner_normal;  // of polygons.corners; kBadIndex where there is none
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
    to.texcoord_cb = [](void* data, double u, double v, double) {
        static_cast<Gathered*>(data)->coordinates.push_back({static_cast<float>(u), static_cast<float>(v)});
    };
    to.normal_cb = [](void* data, double x, double y, double z) {
        static_cast<Gathered*>(data)->normals.push_back({x, y, z});
    };
    to.index_cb = [](void* data, tinyobj::index_t* indices, int count) {
        Gathered& g = *static_cast<Gathered*>(data);
        for (int i = 0; i < count; ++i) {
            g.polygons.corners.push_back(to_index(indices[i].vertex_index, g.polygons.positions.size()));
            g.corner_coordinate.push_back(to_index(indices[i].texcoord_index, g.coordinates.size()));
            g.corner_normal.push_back(to_index(indices[i].normal_index, g.normals.size()));
        }
        g.polygons.end_polygon();
        g.polygons.materials.push_back(g.label);
    };
    to.usemtl_cb = [](void* data, const char* name, int) {
        Gathered& g = *static_cast<Gathered*>(data);
        // 0 is for faces before the first usemtl.
        g.label = g.labels.emplace(name, static_cast<std::uint32_t>(g.labels.size()) + 1).first->second;
    };
    return to;
}

/// A vertex' normal is the mean of those that its corners name.
void add_normals(Gathered& g) {
    std::vector<double> sums(3 * g.polygons.positions.size(), 0);
    bool any = false;
    for (std::size_t i = 0; i < g.polygons.corners.size(); ++i) {
        const std::uint32_t v = g.polygons.corners[i], n = g.corner_normal[i];
        if (v >= g.polygons.positions.size() || n >= g.normals.size()) continue;
        const Vec3 unit = normalized(g.normals[n]);
        for (std::size_t k = 0; k < 3; ++k) sums[3 * v + k] += unit[k];
        any = true;
    }
    if (any) g.polygons.fields.push_back({FieldKind::Normals, "", std::move(sums)});
}

/// The paint of each label that is used; where no material has an image, that of `around` on all.
std::vector<Paint> paints_by_label(const Gathered& g, const std::map<std::string, Paint>& by_name,
                                   const Surroundings& around, std::vector<std::string>& missing) {
    std::vector<Paint> paints(g.labels.size() + 1);
    for (const auto& [name, label] : g.labels)
        if (const auto known = by_name.find(name); known != by_name.end()) paints[label] = known->second;
    const bool painted = std::ranges::any_of(paints, [](const Paint& p) { return p.texture != nullptr; });
    if (painted || around.texture.empty()) return paints;
    Result<Texture> texture = Texture::decode(around.texture);
    if (!texture) missing.push_back(texture.error().message);
    if (!texture) return paints;
    const auto shared = std::make_shared<const Texture>(std::move(*texture));
    for (Paint& p : paints) {
        p = {p.color, p.opaque, shared};
        p.place[1] = {0, -1, 1};  // v runs upwards
    }
    return paints;
}

/// Paints the polygons, unless that tells nothing, or vertices have colours and no image is there.
void add_paints(std::vector<Paint> paints, Gathered& g) {
    constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
    if (g.coordinates.empty())
        for (Paint& p : paints) p.texture.reset();
    std::vector<std::uint8_t> used(paints.size(), 0);
    for (const std::uint32_t label : g.polygons.materials) used[label] = 1;
    // Those that no polygon has are made like one that some has.
    const std::size_t first = static_cast<std::size_t>(std::ranges::find(used, 1) - used.begin());
    for (std::size_t label = 0; label < paints.size(); ++label)
        if (used[label] == 0 && first < paints.size()) paints[label] = paints[first];
    const bool any_image = std::ranges::any_of(paints, [](const Paint& p) { return p.texture != nullptr; });
    if (first == paints.size() || are_plain(paints) || (!any_image && !g.polygons.colors.empty())) return;
    for (const std::uint32_t i : g.corner_coordinate) {
        const auto place = i < g.coordinates.size() ? g.coordinates[i] : std::array{kNowhere, kNowhere};
        g.polygons.coordinates.push_back(place);
    }
    g.polygons.paint_of = g.polygons.materials;
    g.polygons.paints = std::move(paints);
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

Result<Polygons> read_obj(ByteSpan bytes, const Surroundings& around) {
    Gathered gathered;
    const Result<void> fine = check_vertex_lines(as_text(bytes), gathered.polygons.colors);
    if (!fine) return fine.error();
    MemoryBuffer buffer(bytes);
    std::istream stream(&buffer);
    std::string warning, error;
    std::vector<std::string> missing;
    PaintReader paints(around, missing);
    try {
        if (!tinyobj::LoadObjWithCallback(stream, callbacks(), &gathered, &paints, &warning, &error))
            return Error{Errc::Malformed, 0, "is no OBJ: " + error};
    } catch (const std::exception& failure) {
        return Error{Errc::Malformed, 0, std::string("is no OBJ: ") + failure.what()};
    }
    add_normals(gathered);
    add_paints(paints_by_label(gathered, paints.paints(), around, missing), gathered);
    gathered.polygons.missing_textures = std::move(missing);
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
    const VertexField* normals = normals_of(mesh);
    for (std::size_t v = 0; normals != nullptr && v < mesh.positions.size(); ++v)
        fmt::format_to(out, "vn {:.5g} {:.5g} {:.5g}\n", normals->values[3 * v], normals->values[3 * v + 1],
                       normals->values[3 * v + 2]);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        if (!mesh.materials.empty() && (f == 0 || mesh.materials[f] != mesh.materials[f - 1]))
            fmt::format_to(out, "usemtl material_{}\n", mesh.materials[f]);
        const auto [a, b, c] = mesh.faces[f];
        if (normals != nullptr)
            fmt::format_to(out, "f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1, c + 1);
        else
            fmt::format_to(out, "f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    const ByteSpan written = as_bytes({text.data(), text.size()});
    return {written.begin(), written.end()};
}

}  // namespace mvw
