// glTF 2.0, .gltf and .glb, through tinygltf: all triangles of the scene with their nodes' transforms applied.
//
// tinygltf reads the JSON and the buffers; it checks neither accessors against buffers nor the scene for cycles, and it
// recurses into free-form values, so all of that is checked here. Skins and morph targets are left in rest position.
// Compressed and sparse data are made plain first (gltf_unpack.h).
#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "codec/mesh/io/errors.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/gltf_accessor.h"
#include "codec/mesh/io/gltf_node.h"
#include "codec/mesh/io/gltf_paint.h"
#include "codec/mesh/io/gltf_unpack.h"
#include "codec/mesh/io/text.h"
#include "codec/mesh/srgb.h"

namespace mvw {
namespace {

/// Deeper JSON is refused: tinygltf follows it by recursion.
constexpr int kMaxJsonDepth = 100;

/// Gathers the scene's triangles.
class SceneReader {
 public:
    SceneReader(const tinygltf::Model& model, std::uint64_t budget) : model_(model), budget_(budget), paints_(model) {}

    Result<Polygons> read() {
        std::vector<std::pair<int, Affine>> open;  // nodes to visit
        for (const int root : roots()) open.emplace_back(root, Affine{});
        if (model_.nodes.empty())
            for (std::size_t m = 0; m < model_.meshes.size(); ++m)
                if (const auto done = add_mesh(model_.meshes[m], Affine{}); !done) return done.error();
        std::vector<std::uint8_t> visited(model_.nodes.size(), 0);
        while (!open.empty()) {
            const auto [index, outer] = open.back();
            open.pop_back();
            if (!in_range(index, model_.nodes)) return malformed(fmt::format("there is no node {}", index));
            if (std::exchange(visited[static_cast<std::size_t>(index)], 1))
                return malformed(fmt::format("node {} is in the scene twice", index));
            const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(index)];
            const Affine here = outer.after(transform_of(node));
            if (node.mesh >= 0)
                if (const auto done = add_instances(node, here); !done) return done.error();
            for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
                open.emplace_back(*child, here);
        }
        out_.missing_textures = paints_.missing();
        if (!paints_.paint()) return std::move(out_);
        out_.paints = paints_.paints();
        if (!out_.tints.empty()) out_.tints.resize(out_.positions.size(), kNoTint);
        return std::move(out_);
    }

 private:
    /// What a primitive says of its vertices: accessors, -1 for none.
    struct Vertices {
        int position = -1, color = -1, normal = -1;
        std::vector<std::pair<std::string, int>> scalars;  // by attribute name
        friend auto operator<=>(const Vertices&, const Vertices&) = default;
    };

    /// The chosen scene's roots, last first; of a file without scenes the nodes that are nobody's child.
    [[nodiscard]] std::vector<int> roots() const {
        std::vector<int> roots;
        if (!model_.scenes.empty()) {
            const int chosen = in_range(model_.defaultScene, model_.scenes) ? model_.defaultScene : 0;
            roots = model_.scenes[static_cast<std::size_t>(chosen)].nodes;
        } else {
            std::vector<std::uint8_t> is_child(model_.nodes.size(), 0);
            for (const tinygltf::Node& node : model_.nodes)
                for (const int child : node.children)
                    if (in_range(child, model_.nodes)) is_child[static_cast<std::size_t>(child)] = 1;
            for (std::size_t n = 0; n < is_child.size(); ++n)
                if (!is_child[n]) roots.push_back(static_cast<int>(n));
        }
        std::reverse(roots.begin(), roots.end());
        return roots;
    }

    bool spend(std::size_t items) {
        if (items > budget_) return false;
        budget_ -= items;
        return true;
    }

    Result<void> add_instances(const tinygltf::Node& node, const Affine& to_world) {
        if (!in_range(node.mesh, model_.meshes)) return malformed(fmt::format("there is no mesh {}", node.mesh));
        const Result<std::vector<Affine>> instances = instances_of(model_, node);
        if (!instances) return instances.error();
        if (!spend(instances->size())) return over_budget();
        for (const Affine& instance : *instances) {
            const auto& mesh = model_.meshes[static_cast<std::size_t>(node.mesh)];
            if (const auto done = add_mesh(mesh, to_world.after(instance)); !done) return done;
        }
        return {};
    }

    Result<void> add_mesh(const tinygltf::Mesh& mesh, const Affine& to_world) {
        // Primitives of one mesh often share their vertices: each set is placed once.
        std::map<Vertices, std::uint32_t> placed;
        for (const tinygltf::Primitive& primitive : mesh.primitives) {
            const bool strip = primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP;
            const bool fan = primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
            if (!strip && !fan && primitive.mode != TINYGLTF_MODE_TRIANGLES) continue;  // points and lines
            const Vertices vertices = vertices_of(primitive);
            if (vertices.position < 0) continue;  // nothing to draw, says the specification
            const auto [place, is_new] =
                placed.try_emplace(vertices, static_cast<std::uint32_t>(out_.positions.size()));
            if (is_new)
                if (const auto done = add_vertices(vertices, to_world); !done) return done.error();
            if (const auto done =
                    add_triangles(primitive, vertices.position, place->second, to_world.determinant() < 0);
                !done)
                return done.error();
        }
        return {};
    }

    [[nodiscard]] Vertices vertices_of(const tinygltf::Primitive& primitive) const {
        const auto accessor = [&](const std::string& name) {
            const auto found = primitive.attributes.find(name);
            return found == primitive.attributes.end() ? -1 : found->second;
        };
        Vertices out{accessor("POSITION"), accessor("COLOR_0"), accessor("NORMAL"), {}};
        for (const auto& [name, index] : primitive.attributes)
            if (name.size() > 1 && name[0] == '_') out.scalars.emplace_back(name, index);
        return out;
    }

    Result<void> add_vertices(const Vertices& vertices, const Affine& to_world) {
        const Result<Values> points = open_accessor(model_, vertices.position);
        if (!points) return points.error();
        if (points->components != 3) return malformed("positions do not have three coordinates");
        const std::size_t numbers = 1 + vertices.scalars.size() + (vertices.normal >= 0 ? 3u : 0u);
        if (!spend(points->count * numbers)) return over_budget();
        const std::size_t first = out_.positions.size();
        for (std::size_t v = 0; v < points->count; ++v)
            out_.positions.push_back(to_world({points->at(v, 0), points->at(v, 1), points->at(v, 2)}));
        if (vertices.color >= 0)
            if (const auto done = add_colors(vertices.color, first); !done) return done;
        if (vertices.normal >= 0)
            if (const auto done = add_normals(vertices.normal, to_world, first); !done) return done;
        for (const auto& [name, accessor] : vertices.scalars)
            if (const auto done = add_scalar(name, accessor, first); !done) return done;
        return {};
    }

    /// Those of an accessor with a row for each vertex from `first` on; `least` numbers a row.
    Result<Values> open_of_vertices(int accessor, std::size_t first, std::size_t least, const char* what) {
        Result<Values> values = open_accessor(model_, accessor);
        if (values && (values->count != out_.positions.size() - first || values->components < least))
            return malformed(fmt::format("{} do not fit their vertices", what));
        return values;
    }

    /// They are of light, and multiplied with paints where there are some.
    Result<void> add_colors(int accessor, std::size_t first) {
        const Result<Values> colors = open_of_vertices(accessor, first, 3, "colours");
        if (!colors) return colors.error();
        out_.tints.resize(first, kNoTint);
        out_.colors.resize(first);  // white where earlier primitives have none
        for (std::size_t v = 0; v < colors->count; ++v) {
            std::array<double, 4> c{1, 1, 1, 1};
            for (std::size_t k = 0; k < std::min<std::size_t>(colors->components, 4); ++k) c[k] = colors->at(v, k);
            out_.colors.push_back(to_srgb(c));
            out_.tints.push_back({});
            for (std::size_t k = 0; k < 4; ++k) out_.tints.back()[k] = static_cast<float>(std::clamp(c[k], 0.0, 1.0));
        }
        return {};
    }

    Result<void> add_normals(int accessor, const Affine& to_world, std::size_t first) {
        const Result<Values> normals = open_of_vertices(accessor, first, 3, "normals");
        if (!normals) return normals.error();
        const auto field = field_of(out_, FieldKind::Normals, "");
        for (std::size_t v = 0; field && v < normals->count; ++v) {
            const Vec3 n = to_world.normal({normals->at(v, 0), normals->at(v, 1), normals->at(v, 2)});
            set_value(out_.fields[*field], first + v, std::array{n.x, n.y, n.z});
        }
        return {};
    }

    /// Attributes of other sizes are not kept.
    Result<void> add_scalar(const std::string& name, int accessor, std::size_t first) {
        const Result<Values> values = open_of_vertices(accessor, first, 1, "numbers");
        if (!values) return values.error();
        if (values->components > 1) return drop_field(out_, name.substr(0, kMaxFieldName)), Result<void>{};
        const auto field = field_of(out_, FieldKind::Scalar, name.substr(1));
        for (std::size_t v = 0; field && v < values->count; ++v)
            set_value(out_.fields[*field], first + v, std::array{values->at(v, 0)});
        return {};
    }

    Result<void> add_triangles(const tinygltf::Primitive& primitive, int position, std::uint32_t base, bool mirrored) {
        const Result<Values> points = open_accessor(model_, position);
        if (!points) return points.error();
        Values indices;
        std::size_t count = points->count;
        if (primitive.indices >= 0) {
            const Result<Values> opened = open_accessor(model_, primitive.indices);
            if (!opened) return opened.error();
            indices = *opened;
            const bool whole = indices.type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                               indices.type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                               indices.type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
            if (indices.components != 1 || !whole || indices.normalized)
                return malformed("indices are of a wrong type");
            count = indices.count;
        }
        if (!spend(count)) return over_budget();
        const auto vertex = [&](std::size_t i) {
            const double v = primitive.indices >= 0 ? indices.at(i, 0) : static_cast<double>(i);
            return v < static_cast<double>(points->count) ? base + static_cast<std::uint32_t>(v) : kBadIndex;
        };
        const std::uint32_t paint = paints_.number_of(primitive.material);
        const Result<Values> coordinates = coordinates_of(primitive, paint, points->count);
        if (!coordinates) return coordinates.error();
        const auto place = [&](std::size_t i) -> std::array<float, 2> {
            constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
            const std::uint32_t v = vertex(i) - base;
            if (v >= coordinates->count) return {kNowhere, kNowhere};
            return {static_cast<float>(coordinates->at(v, 0)), static_cast<float>(coordinates->at(v, 1))};
        };
        const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
            if (mirrored) std::swap(b, c);
            for (const std::size_t i : {a, b, c}) {
                out_.corners.push_back(vertex(i));
                if (paints_.paint()) out_.coordinates.push_back(place(i));
            }
            out_.end_polygon();
            if (paints_.paint()) out_.paint_of.push_back(paint);
            out_.materials.push_back(static_cast<std::uint32_t>(primitive.material + 1));
        };
        if (primitive.mode == TINYGLTF_MODE_TRIANGLES)
            for (std::size_t i = 0; i + 2 < count; i += 3) add(i, i + 1, i + 2);
        else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP)
            for (std::size_t i = 0; i + 2 < count; ++i) add(i, i + 1 + i % 2, i + 2 - i % 2);
        else
            for (std::size_t i = 1; i + 1 < count; ++i) add(i, i + 1, 0);
        return {};
    }

    /// Where in its paint's image each of a primitive's vertices lies; none where it has no image or does not say.
    [[nodiscard]] Result<Values> coordinates_of(const tinygltf::Primitive& primitive, std::uint32_t paint,
                                                std::size_t vertices) const {
        const auto found = primitive.attributes.find(paints_.coordinates_of(paint));
        if (!paints_.paints()[paint].texture || found == primitive.attributes.end()) return Values{};
        Result<Values> values = open_accessor(model_, found->second);
        if (values && (values->count != vertices || values->components < 2))
            return malformed("texture coordinates do not fit their vertices");
        return values;
    }

    const tinygltf::Model& model_;
    std::uint64_t budget_;
    const GltfPaints paints_;
    static constexpr std::array<float, 4> kNoTint{1, 1, 1, 1};
    Polygons out_;
};

constexpr std::size_t kGlbHead = 20;  // up to the JSON: the file's head and its first chunk's

/// The JSON of either kind of file, as far as it is there.
std::string_view json_of(std::string_view text, bool binary) {
    if (!binary) return text;
    if (text.size() < kGlbHead) return {};
    ByteReader head(as_bytes(text.substr(0, kGlbHead)));
    head.bytes(12);
    return text.substr(kGlbHead, head.u32());
}

/// tinygltf copies the binary chunk for each buffer without a URI, however many claim it: all but the first are
/// refused.
Result<void> check_buffers(const nlohmann::json& gltf) {
    const auto buffers = gltf.find("buffers");
    if (buffers == gltf.end()) return malformed("has no faces");
    if (!buffers->is_array()) return malformed("is no valid glTF: buffers are no list");
    for (std::size_t b = 1; b < buffers->size(); ++b)
        if (!(*buffers)[b].is_object() || !(*buffers)[b].contains("uri"))
            return malformed(fmt::format("buffer {} has no data", b));
    return {};
}

Result<void> check_features(const nlohmann::json& gltf) {
    const auto asset = gltf.find("asset");
    if (asset != gltf.end() && asset->is_object() && asset->contains("version"))
        if (const auto& version = (*asset)["version"]; version.is_string() && version.get<std::string>() < "2")
            return Error{Errc::Unsupported, 0, "is glTF " + version.get<std::string>() + ": only 2.0 is known"};
    const auto required = gltf.find("extensionsRequired");
    if (required != gltf.end() && required->is_array())
        for (const nlohmann::json& name : *required)
            if (name == "KHR_meshopt_compression")
                return Error{Errc::Unsupported, 0, "needs the extension KHR_meshopt_compression, which is not known"};
    return {};
}

/// What tinygltf would follow without a bound.
Result<void> check_depth(std::string_view json) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (in_string) {
            if (c == '\\') ++i;
            in_string = c != '"';
        } else if (c == '"') {
            in_string = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMaxJsonDepth) return Error{Errc::LimitExceeded, 0, "nests its JSON too deep"};
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
    return {};
}

/// The file's JSON as tinygltf is to see it, checked; empty where it may see it as it is.
Result<std::string> json_for_tinygltf(std::string_view text) {
    if (const auto fine = check_depth(text); !fine) return fine.error();
    nlohmann::json gltf = nlohmann::json::parse(text.begin(), text.end(), nullptr, false);
    if (!gltf.is_object()) return malformed("is no valid glTF: its JSON is damaged");
    if (const auto fine = check_features(gltf); !fine) return fine.error();
    const bool changed = complete_for_tinygltf(gltf);
    if (const auto fine = check_buffers(gltf); !fine) return fine.error();
    return changed ? gltf.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) : std::string();
}

/// tinygltf forgets the head of the binary chunk when it holds its length against the file's (as of 2.7.0).
Result<void> check_binary_chunk(ByteSpan file) {
    const std::size_t at = std::min(file.size(), kGlbHead + json_of(as_text(file), true).size());
    ByteReader in(file.subspan(at));
    const std::uint32_t length = in.u32();
    in.u32();  // type
    if (in.ok() && length > in.remaining()) return malformed("is no valid glTF: its binary chunk is cut");
    return {};
}

/// The file with other JSON.
Bytes with_json(ByteSpan file, bool binary, std::string json) {
    if (!binary) return Bytes(as_bytes(json).begin(), as_bytes(json).end());
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t old = json_of(as_text(file), true).size();
    const ByteSpan behind = file.subspan(kGlbHead + old);
    ByteWriter out;
    out.bytes(file.first(8));
    out.u32(static_cast<std::uint32_t>(kGlbHead + json.size() + behind.size()));
    out.u32(static_cast<std::uint32_t>(json.size()));
    out.bytes(file.subspan(16, 4));
    out.bytes(as_bytes(json));
    out.bytes(behind);
    return out.take();
}

// tinygltf asks these for outer buffers and images. They see the folder of the .gltf and what is below it, nothing
// else; it comes through `data`, as Surroundings.
bool file_exists(const std::string&, void* data) {
    return static_cast<const Surroundings*>(data)->folder != nullptr;
}
std::string same_path(const std::string& path, void*) {
    return path;
}
bool read_whole_file(std::vector<unsigned char>* out, std::string* error, const std::string& path, void* data) {
    const std::string* folder = static_cast<const Surroundings*>(data)->folder;
    if (folder == nullptr || !path.starts_with(*folder)) return false;
    const Result<Bytes> bytes = read_file_below(folder, path.substr(folder->size()));
    if (!bytes) return *error = bytes.error().message, false;
    const auto* begin = reinterpret_cast<const unsigned char*>(bytes->data());
    out->assign(begin, begin + bytes->size());
    return true;
}
bool write_no_file(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
}
/// Keeps the bytes of images that come in files or in the JSON; those in buffers are opened later, with checks.
bool keep_image(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes, int size,
                void*) {
    if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
    return true;
}

Result<void> load(ByteSpan bytes, bool binary, const Surroundings& around, tinygltf::Model& model) {
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_image, nullptr);
    loader.SetFsCallbacks({file_exists, same_path, read_whole_file, write_no_file, const_cast<Surroundings*>(&around)});
    std::string error, warning;
    bool loaded = false;
    const auto size = static_cast<unsigned>(bytes.size());
    const std::string base = around.folder != nullptr ? *around.folder : "";
    try {
        loaded = binary ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                                      reinterpret_cast<const unsigned char*>(bytes.data()), size, base)
                        : loader.LoadASCIIFromString(&model, &error, &warning,
                                                     reinterpret_cast<const char*>(bytes.data()), size, base);
    } catch (const std::exception& failure) {
        error = failure.what();
    }
    if (loaded) return {};
    std::replace(error.begin(), error.end(), '\n', ' ');
    return malformed("is no valid glTF: " + error.substr(0, 200));
}

}  // namespace

Result<Polygons> read_gltf(ByteSpan bytes, bool binary, const Surroundings& around) {
    if (bytes.size() > 0xFFFFFFFFu) return Error{Errc::LimitExceeded, 0, "is over 4 GB, which glTF does not allow"};
    Result<std::string> json = json_for_tinygltf(json_of(as_text(bytes), binary));
    if (!json) return json.error();
    if (const auto fine = binary ? check_binary_chunk(bytes) : Result<void>(); !fine) return fine.error();
    tinygltf::Model model;
    const Bytes completed = json->empty() ? Bytes() : with_json(bytes, binary, std::move(json).value());
    if (const auto loaded = load(completed.empty() ? bytes : ByteSpan(completed), binary, around, model); !loaded)
        return loaded.error();
    if (const auto done = unpack(model); !done) return done.error();
    std::uint64_t size = bytes.size();
    for (const tinygltf::Buffer& buffer : model.buffers) size += buffer.data.size();
    return SceneReader(model, budget_of_instances(size)).read();
}

}  // namespace mvw
