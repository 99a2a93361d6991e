// 3MF, the 3D Manufacturing Format: objects in XML, in a ZIP archive, and where each of them is built.
//
// An own reader over libzip and Expat: lib3mf, as Debian has it, keeps all of a package in objects of its own before it
// hands out a vertex, and does not bound what a short archive may unfold to; assimp does not know the format's parts.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "codec/mesh/io/errors.h"
#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/threemf_model.h"
#include "codec/mesh/io/zip.h"
#include "codec/mesh/srgb.h"

namespace mvw {

namespace {

/// XML may be so many times as long as its archive, and this many bytes more. (Of the 84 packages that Cura 4.13 has
/// in Debian 14 is the most.)
constexpr std::uint64_t kMostUnfolding = 50, kFreeBytes = 1u << 20;
constexpr std::uint64_t kCostOfPlace = 16;  // of what is placed, in vertices: it is looked up by name
constexpr int kMostNesting = 32;
constexpr std::size_t kMostMaterials = 256;  // above, colours are those of vertices: borders of materials take bytes
constexpr const char *kRelationships = "/_rels/.rels", *kUsualModel = "/3D/3dmodel.model";

std::string with_slash(const std::string& path) {
    return path.starts_with('/') ? path : '/' + path;
}

/// Gathers what is built.
class PackageReader {
 public:
    PackageReader(const ZipArchive& archive, std::uint64_t bytes)
        : archive_(archive), xml_left_(bytes * kMostUnfolding + kFreeBytes), left_(budget_of_instances(bytes)) {}

    Result<Polygons> read() {
        const Result<std::string> path = path_of_model();
        if (!path) return path.error();
        const auto model = model_at(*path);
        if (!model) return model.error();
        for (const ThreemfPlace& item : (*model)->items)
            if (const auto done = add(item, *path, {}, 0); !done) return done.error();
        if ((*model)->items.empty())
            for (const auto& [id, object] : (*model)->objects)
                if (object.components.empty())
                    if (const auto done = add({{}, id, {}}, *path, {}, 0); !done) return done.error();
        if (leaves_out_colors_)
            out_.missing_textures.emplace_back("images and mixed colours of 3MF: their triangles are white");
        paint();
        return std::move(out_);
    }

 private:
    [[nodiscard]] ThreemfPieces pieces(const std::string& path) {
        return [this, name = path.substr(1)](const auto& take) {
            return archive_.read(name, xml_left_, [&](ByteSpan piece) {
                xml_left_ -= piece.size();
                return take(piece);
            });
        };
    }
    Result<std::string> path_of_model() {
        if (!archive_.has(kRelationships + 1)) return std::string(kUsualModel);
        Result<std::string> path = model_of_relationships(pieces(kRelationships));
        if (path && path->empty()) return malformed("has no 3D model");
        return path ? with_slash(*path) : path;
    }
    Result<const ThreemfModel*> model_at(const std::string& path) {
        std::string key = path;  // names of parts are told apart so
        for (char& c : key)
            if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
        const auto known = models_.find(key);
        if (known != models_.end()) return &known->second;
        Result<ThreemfModel> model = read_threemf_model(pieces(path));
        if (!model) return Error{model.error().code, 0, path.substr(1) + ": " + model.error().message};
        leaves_out_colors_ = leaves_out_colors_ || model->leaves_out_colors;
        return &models_.emplace(std::move(key), std::move(*model)).first->second;
    }

    Result<void> add(const ThreemfPlace& place, const std::string& outer_path, const Affine& outer, int depth) {
        const std::string path = place.path.empty() ? outer_path : with_slash(place.path);
        const auto model = model_at(path);
        if (!model) return model.error();
        const auto found = (*model)->objects.find(place.object);
        if (found == (*model)->objects.end()) return malformed(fmt::format("there is no object {}", place.object));
        if (depth == kMostNesting) return Error{Errc::LimitExceeded, 0, "nests its components too deep"};
        const ThreemfObject& object = found->second;
        if (object.is_other) return {};
        const std::uint64_t cost = kCostOfPlace + object.positions.size() + 3 * object.faces.size();
        if (cost > left_) return over_budget();
        left_ -= cost;
        const Affine here = outer.after(place.to_outer);
        for (const ThreemfPlace& component : object.components)
            if (auto done = add(component, path, here, depth + 1); !done) return done;
        return add_mesh(object, **model, here);
    }
    Result<void> add_mesh(const ThreemfObject& object, const ThreemfModel& model, const Affine& to_world) {
        const auto first = static_cast<std::uint32_t>(out_.positions.size());
        for (const Vec3& p : object.positions) out_.positions.push_back(to_world(p));
        const bool mirrored = to_world.determinant() < 0;
        for (std::size_t f = 0; f < object.faces.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t corner = mirrored ? 2 - k : k;
                const std::uint32_t v = object.faces[f][corner], color = object.colors[f][corner];
                if (v >= object.positions.size())
                    return malformed(fmt::format("a triangle names vertex {} of {}", v, object.positions.size()));
                out_.corners.push_back(first + v);
                colors_.push_back(color == ThreemfModel::kNoColor ? Rgba8{255, 255, 255, 255} : model.colors[color]);
            }
            out_.end_polygon();
        }
        return {};
    }

    /// Colours of materials where each triangle has one and these are few, else of vertices: the mean of their
    /// corners'.
    void paint() {
        const auto key = [](const Rgba8& c) { return std::uint32_t{c.r} << 24 | c.g << 16 | c.b << 8 | c.a; };
        const auto is_one = [&](std::size_t f) {
            return colors_[3 * f] == colors_[3 * f + 1] && colors_[3 * f] == colors_[3 * f + 2];
        };
        std::map<std::uint32_t, std::uint32_t> labels;
        for (std::size_t f = 0; f < out_.count(); ++f) {
            if (!is_one(f) || labels.size() > kMostMaterials) return paint_vertices();
            const auto label = static_cast<std::uint32_t>(out_.paints.size());
            const auto [at, is_new] = labels.emplace(key(colors_[3 * f]), label);
            if (is_new) out_.paints.emplace_back().color = to_linear(colors_[3 * f]);
            out_.paint_of.push_back(at->second);
        }
        out_.materials = out_.paint_of;
        constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
        out_.coordinates.assign(out_.corners.size(), {kNowhere, kNowhere});
        if (!are_plain(out_.paints)) return;
        out_.paints.clear();
        out_.paint_of.clear();
        out_.coordinates.clear();
    }
    void paint_vertices() {
        out_.paints.clear();
        out_.paint_of.clear();
        out_.colors.assign(out_.positions.size(), {255, 255, 255, 255});
        std::vector<std::array<double, 5>> sums(out_.positions.size());
        for (std::size_t i = 0; i < out_.corners.size(); ++i) {
            const std::array<double, 4> color = to_linear(colors_[i]);
            for (std::size_t k = 0; k < 4; ++k) sums[out_.corners[i]][k] += color[k];
            ++sums[out_.corners[i]][4];
        }
        for (std::size_t v = 0; v < sums.size(); ++v)
            if (const auto& [r, g, b, a, n] = sums[v]; n > 0) out_.colors[v] = to_srgb({r / n, g / n, b / n, a / n});
    }

    const ZipArchive& archive_;
    std::uint64_t xml_left_, left_;
    std::map<std::string, ThreemfModel> models_;  // by path, in small letters
    bool leaves_out_colors_ = false;
    std::vector<Rgba8> colors_;  // of each corner
    Polygons out_;
};

}  // namespace

Result<Polygons> read_3mf(ByteSpan bytes) {
    const Result<ZipArchive> archive = ZipArchive::open(bytes);
    if (!archive) return archive.error();
    return PackageReader(*archive, bytes.size()).read();
}

}  // namespace mvw
