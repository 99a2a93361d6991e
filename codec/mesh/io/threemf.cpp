// 3MF, the 3D Manufacturing Format: objects in XML, in a ZIP archive, and where each of them is built.
//
// An own reader over libzip and Expat: lib3mf, as Debian has it, keeps all of a package in objects of its own before it
// hands out a vertex, and does not bound what a short archive may unfold to; assimp does not know the format's parts.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/threemf_model.h"
#include "codec/mesh/io/zip.h"
#include "codec/mesh/srgb.h"

namespace mvw {

namespace {

/// XML may be so many times as long as its archive, and this many bytes more. (Of the 84 packages that Cura 4.13 has
/// in Debian 14 is the most.)
constexpr std::uint64_t kMostUnfolding = 200, kFreeBytes = 1u << 20;
/// Likewise vertices and corners of all that is built: components may stand anywhere any number of times.
constexpr std::uint64_t kMostInstancing = 1000, kFreeInstances = 1'000'000;
constexpr int kMostNesting = 32;
constexpr const char *kRelationships = "/_rels/.rels", *kUsualModel = "/3D/3dmodel.model";

Error malformed(std::string reason) {
    return {Errc::Malformed, 0, std::move(reason)};
}

std::string with_slash(const std::string& path) {
    return path.starts_with('/') ? path : '/' + path;
}

/// Gathers what is built.
class PackageReader {
 public:
    PackageReader(const ZipArchive& archive, std::uint64_t bytes)
        : archive_(archive),
          xml_left_(bytes * kMostUnfolding + kFreeBytes),
          left_(bytes * kMostInstancing + kFreeInstances) {}

    Result<Polygons> read() {
        const Result<std::string> path = path_of_model();
        if (!path) return path.error();
        const auto model = model_at(*path);
        if (!model) return model.error();
        std::vector<ThreemfPlace> items = (*model)->items;
        if (items.empty())
            for (const auto& [id, object] : (*model)->objects)
                if (object.components.empty()) items.push_back({{}, id, {}});
        for (const ThreemfPlace& item : items)
            if (const auto done = add(item, *path, {}, 0); !done) return done.error();
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
        const auto known = models_.find(path);
        if (known != models_.end()) return &known->second;
        Result<ThreemfModel> model = read_threemf_model(pieces(path));
        if (!model) return Error{model.error().code, 0, path.substr(1) + ": " + model.error().message};
        if (model->has_textures)
            out_.missing_textures.emplace_back("images of 3MF files are not read: their triangles have no colour");
        return &models_.emplace(path, std::move(*model)).first->second;
    }

    Result<void> add(const ThreemfPlace& place, const std::string& outer_path, const Affine& outer, int depth) {
        const std::string path = place.path.empty() ? outer_path : with_slash(place.path);
        const auto model = model_at(path);
        if (!model) return model.error();
        const auto found = (*model)->objects.find(place.object);
        if (found == (*model)->objects.end()) return malformed(fmt::format("there is no object {}", place.object));
        if (depth == kMostNesting) return Error{Errc::LimitExceeded, 0, "nests its components too deep"};
        const ThreemfObject& object = found->second;
        const std::uint64_t cost = 1 + object.positions.size() + 3 * object.faces.size();
        if (cost > left_)
            return Error{Errc::LimitExceeded, 0, "places its objects so often that they are too large together"};
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

    /// Colours of materials where each triangle has one, else of vertices: the mean of their corners'.
    void paint() {
        const auto key = [](const Rgba8& c) { return std::uint32_t{c.r} << 24 | c.g << 16 | c.b << 8 | c.a; };
        const auto is_one = [&](std::size_t f) {
            return colors_[3 * f] == colors_[3 * f + 1] && colors_[3 * f] == colors_[3 * f + 2];
        };
        std::map<std::uint32_t, std::uint32_t> labels;
        for (std::size_t f = 0; f < out_.count(); ++f) {
            if (!is_one(f)) return paint_vertices();
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
        std::vector<std::array<double, 5>> sums(out_.positions.size());
        for (std::size_t i = 0; i < out_.corners.size(); ++i) {
            const std::array<double, 4> color = to_linear(colors_[i]);
            for (std::size_t k = 0; k < 4; ++k) sums[out_.corners[i]][k] += color[k];
            ++sums[out_.corners[i]][4];
        }
        for (const auto& [r, g, b, a, n] : sums) {
            const double count = std::max(n, 1.0);
            out_.colors.push_back(to_srgb({r / count, g / count, b / count, a / count}));
        }
    }

    const ZipArchive& archive_;
    std::uint64_t xml_left_, left_;
    std::map<std::string, ThreemfModel> models_;  // by path
    std::vector<Rgba8> colors_;                   // of each corner
    Polygons out_;
};

}  // namespace

Result<Polygons> read_3mf(ByteSpan bytes) {
    const Result<ZipArchive> archive = ZipArchive::open(bytes);
    if (!archive) return archive.error();
    return PackageReader(*archive, bytes.size()).read();
}

}  // namespace mvw
