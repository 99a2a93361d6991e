#include "codec/remesh/recognize.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>

#include "codec/mesh/clean.h"
#include "codec/mesh/half_edges.h"

namespace mvw {

namespace {

// What a face is in its group of four: the one in the middle, or the one at an old vertex, which is its corner 0, 1, 2.
constexpr std::uint8_t kMiddle = 3;
constexpr std::uint8_t kUnknown = 255;

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
}

/// A mesh with fewer levels, in the vertex numbers of the finest one.
struct Coarser {
    std::vector<Face> faces;
    std::vector<std::uint32_t> materials;                     // of `faces`; empty where there are none
    std::unordered_map<std::uint64_t, std::uint32_t> middle;  // of each edge of `faces`: the vertex that split it
};

std::vector<std::uint32_t> mates_of(const std::vector<Face>& faces, std::uint32_t vertices) {
    std::vector<std::uint32_t> mates(faces.size() * 3, kNone);
    const EdgeGroups groups = group_edges(faces, vertices);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].size() != 2) continue;
        mates[groups[g][0]] = groups[g][1];
        mates[groups[g][1]] = groups[g][0];
    }
    return mates;
}

/// Undoes one quadrisection of a connected mesh.
class Coarsening {
 public:
    Coarsening(const std::vector<Face>& faces, const std::vector<std::uint32_t>& materials, std::uint32_t vertices)
        : faces_(faces), materials_(materials), vertices_(vertices), mates_(mates_of(faces, vertices)) {}

    /// With face 0 in that role, which decides all others; none where they do not agree.
    std::optional<Coarser> attempt(std::uint8_t role_of_first) {
        roles_.assign(faces_.size(), kUnknown);
        stack_.assign(1, 0);
        roles_[0] = role_of_first;
        while (!stack_.empty()) {
            const std::uint32_t f = stack_.back();
            stack_.pop_back();
            if (!spread(f)) return std::nullopt;
        }
        return parity_agrees() ? gather() : std::nullopt;
    }

 private:
    bool give(std::uint32_t face, std::uint32_t role) {
        if (roles_[face] != kUnknown) return roles_[face] == role;
        roles_[face] = static_cast<std::uint8_t>(role);
        stack_.push_back(face);
        return true;
    }

    /// Gives f's neighbours the roles that follow from its own.
    bool spread(std::uint32_t f) {
        const std::uint32_t role = roles_[f];
        for (std::uint32_t s = 0; s < 3; ++s) {
            const std::uint32_t mate = mates_[3 * f + s];
            if (role == kMiddle) {
                if (mate == kNone || !give(mate / 3, (mate % 3 + 2) % 3)) return false;
            } else if (s == (role + 1) % 3) {  // the side opposite to the old vertex
                if (mate == kNone || !give(mate / 3, kMiddle)) return false;
            } else if (mate != kNone) {  // the old vertex goes on round its fan
                if (!give(mate / 3, s == role ? (mate % 3 + 1) % 3 : mate % 3)) return false;
            }
        }
        return true;
    }

    /// Whether each vertex is old in all its faces or new in all.
    [[nodiscard]] bool parity_agrees() const {
        std::vector<std::uint8_t> parity(vertices_, kUnknown);
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint8_t old = roles_[f] == k ? 1 : 0;
                std::uint8_t& known = parity[faces_[f][k]];
                if (known != kUnknown && known != old) return false;
                known = old;
            }
        }
        return true;
    }

    [[nodiscard]] std::optional<Coarser> gather() const {
        Coarser out;
        std::vector<std::uint64_t> edge_of(vertices_, 0);  // of each new vertex; 0 is no edge's key
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            if (roles_[f] != kMiddle) continue;
            Face old{};
            for (std::uint32_t s = 0; s < 3; ++s) old[s] = origin(faces_, previous_half_edge(mates_[3 * f + s]));
            for (std::uint32_t s = 0; s < 3; ++s) {
                // Corner s + 1 of the middle one lies between the old vertices beyond sides s and s + 1.
                const std::uint64_t key = edge_key(old[s], old[(s + 1) % 3]);
                const std::uint32_t middle = faces_[f][(s + 1) % 3];
                if (old[s] == old[(s + 1) % 3]) return std::nullopt;
                if (out.middle.emplace(key, middle).first->second != middle) return std::nullopt;
                if (edge_of[middle] != 0 && edge_of[middle] != key) return std::nullopt;
                edge_of[middle] = key;
            }
            out.faces.push_back(old);
            if (materials_.empty()) continue;
            for (std::uint32_t s = 0; s < 3; ++s)
                if (materials_[mates_[3 * f + s] / 3] != materials_[f]) return std::nullopt;
            out.materials.push_back(materials_[f]);
        }
        return out.faces.size() * 4 == faces_.size() ? std::optional(std::move(out)) : std::nullopt;
    }

    const std::vector<Face>& faces_;
    const std::vector<std::uint32_t>& materials_;
    std::uint32_t vertices_;
    std::vector<std::uint32_t> mates_;
    std::vector<std::uint8_t> roles_;
    std::vector<std::uint32_t> stack_;
};

/// Numbers the used vertices 0, 1, ... in order of first use.
std::vector<Face> compact(const std::vector<Face>& faces, std::vector<std::uint32_t>& vertices) {
    std::unordered_map<std::uint32_t, std::uint32_t> number;
    std::vector<Face> out = faces;
    for (Face& f : out) {
        for (std::uint32_t& v : f) {
            const auto [at, is_new] = number.emplace(v, static_cast<std::uint32_t>(vertices.size()));
            if (is_new) vertices.push_back(v);
            v = at->second;
        }
    }
    return out;
}

/// Coarser and coarser meshes, the longest chain there is. materials: of each face, or empty.
std::vector<Coarser> longest_chain(const std::vector<Face>& faces, const std::vector<std::uint32_t>& materials) {
    std::vector<Coarser> best;
    if (faces.size() % 4 != 0 || faces.empty()) return best;
    std::vector<std::uint32_t> vertices;
    const std::vector<Face> local = compact(faces, vertices);
    Coarsening coarsening(local, materials, static_cast<std::uint32_t>(vertices.size()));
    for (const std::uint8_t role : {kMiddle, std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{2}}) {
        std::optional<Coarser> coarser = coarsening.attempt(role);
        if (!coarser) continue;
        for (Face& f : coarser->faces)
            for (std::uint32_t& v : f) v = vertices[v];
        std::unordered_map<std::uint64_t, std::uint32_t> middle;
        for (const auto& [key, v] : coarser->middle)
            middle.emplace(edge_key(vertices[key >> 32], vertices[key & 0xFFFFFFFFu]), vertices[v]);
        coarser->middle = std::move(middle);
        std::vector<std::uint32_t> used;
        if (!BaseMesh::create(static_cast<std::uint32_t>(vertices.size()), compact(coarser->faces, used))) continue;
        std::vector<Coarser> chain = longest_chain(coarser->faces, coarser->materials);
        chain.insert(chain.begin(), std::move(*coarser));
        if (chain.size() > best.size()) best = std::move(chain);
    }
    return best;
}

/// Numbers of all grid points, level by level from the base's corners.
std::vector<std::uint32_t> name_grid(const BaseMesh& base, const std::vector<std::uint32_t>& corners,
                                     const std::vector<Coarser>& chain) {
    const auto levels = static_cast<unsigned>(chain.size());
    std::vector<std::uint32_t> names(vertices_at_level(base, levels), kNone);
    std::copy(corners.begin(), corners.end(), names.begin());
    for (unsigned level = 1; level <= levels; ++level) {
        const auto& middle = chain[levels - level].middle;
        const std::uint32_t n = 1u << level;
        for (std::uint32_t f = 0; f < base.face_count(); ++f) {
            const auto name = [&](std::uint32_t i, std::uint32_t k) -> std::uint32_t& {
                return names[vertex_index(base, f, level, i, k)];
            };
            for (std::uint32_t i = 0; i <= n; ++i) {
                for (std::uint32_t k = i % 2 == 0 ? 1 : 0; i + k <= n; k += i % 2 == 0 ? 2 : 1) {
                    // A new point halves the edge of the coarser grid that it lies on: along i, along k, or across.
                    const std::uint32_t di = i % 2, dk = k % 2;
                    const std::uint32_t a = name(i - di, di != 0 && dk != 0 ? k + 1 : k - dk);
                    const std::uint32_t b = name(i + di, di != 0 && dk != 0 ? k - 1 : k + dk);
                    name(i, k) = middle.at(edge_key(a, b));
                }
            }
        }
    }
    return names;
}

/// The chains of several components, all of one length, as one mesh.
Recognized joined(const std::vector<std::vector<Coarser>>& chains, const std::vector<std::uint32_t>& which) {
    std::vector<Coarser> all(chains[which[0]].size());
    for (const std::uint32_t c : which) {
        for (std::size_t k = 0; k < all.size(); ++k) {
            const Coarser& from = chains[c][k];
            all[k].faces.insert(all[k].faces.end(), from.faces.begin(), from.faces.end());
            all[k].materials.insert(all[k].materials.end(), from.materials.begin(), from.materials.end());
            all[k].middle.insert(from.middle.begin(), from.middle.end());
        }
    }
    Recognized out;
    std::vector<std::uint32_t> corners;
    std::vector<Face> faces = compact(all.back().faces, corners);
    out.base = BaseMesh::create(static_cast<std::uint32_t>(corners.size()), std::move(faces)).value();
    out.materials = std::move(all.back().materials);
    out.levels = static_cast<unsigned>(all.size());
    out.vertices = name_grid(out.base, corners, all);
    return out;
}

}  // namespace

Recognition recognize(const Mesh& mesh, unsigned least_levels) {
    std::vector<std::uint32_t> component_of_face;
    const std::vector<Component> parts = components(mesh, component_of_face);
    std::vector<std::vector<Face>> faces(parts.size());
    std::vector<std::vector<std::uint32_t>> materials(parts.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        faces[component_of_face[f]].push_back(mesh.faces[f]);
        if (!mesh.materials.empty()) materials[component_of_face[f]].push_back(mesh.materials[f]);
    }

    Recognition out;
    out.mesh_of_component.assign(parts.size(), kNone);
    std::vector<std::vector<Coarser>> chains;
    std::map<std::size_t, std::vector<std::uint32_t>, std::greater<>> by_levels;
    for (std::uint32_t c = 0; c < parts.size(); ++c) {
        chains.push_back(longest_chain(faces[c], materials[c]));
        if (chains[c].size() >= least_levels) by_levels[chains[c].size()].push_back(c);
    }
    for (const auto& [levels, which] : by_levels) {
        for (const std::uint32_t c : which) out.mesh_of_component[c] = static_cast<std::uint32_t>(out.meshes.size());
        out.meshes.push_back(joined(chains, which));
    }
    return out;
}

}  // namespace mvw
