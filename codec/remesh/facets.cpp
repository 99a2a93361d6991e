#include "codec/remesh/facets.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <queue>
#include <utility>

#include "codec/mesh/vertex_data.h"
#include "codec/remesh/resample.h"

namespace mvw {

namespace {

constexpr std::size_t kMostTogether = 16'384;  // faces of all such components
constexpr std::uint32_t kFewEars = 4;          // vertices for each one of a single face, at least, ...
constexpr std::size_t kFacesOfEars = 5;        // ... or else so many faces for each of their component

/// What of a component decides.
struct Counts {
    std::uint32_t faces = 0, vertices = 0, ears = 0;
};

bool has_ears(const Counts& counts) {
    return counts.ears * kFewEars >= counts.vertices;
}

std::vector<Counts> count(const Mesh& mesh, const std::vector<std::uint32_t>& component_of_face,
                          std::size_t components) {
    std::vector<Counts> counts(components);
    std::vector<std::uint32_t> faces_at(mesh.positions.size(), 0), component_of(mesh.positions.size(), 0);
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        ++counts[component_of_face[f]].faces;
        for (const std::uint32_t v : mesh.faces[f]) ++faces_at[v], component_of[v] = component_of_face[f];
    }
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        if (faces_at[v] == 0) continue;
        ++counts[component_of[v]].vertices;
        if (faces_at[v] == 1) ++counts[component_of[v]].ears;
    }
    return counts;
}

}  // namespace

std::vector<std::uint8_t> choose_facets(const Mesh& mesh, const std::vector<std::uint32_t>& component_of_face,
                                        std::size_t components, bool allow_ears,
                                        const std::function<bool(std::uint32_t)>& wanted) {
    const std::vector<Counts> counts = count(mesh, component_of_face, components);
    std::vector<std::uint8_t> chosen(components, 0);
    std::size_t together = 0;
    for (std::uint32_t c = 0; c < components; ++c) {
        if (!wanted(c) || counts[c].faces > kMostFacets || has_ears(counts[c])) continue;
        chosen[c] = 1;
        together += counts[c].faces;
    }
    if (together > kMostTogether) return std::vector<std::uint8_t>(components, 0);
    for (std::uint32_t c = 0; c < components && allow_ears; ++c) {
        const std::size_t faces = kFacesOfEars * counts[c].faces;
        const bool fits = counts[c].faces <= kMostFacets && together + faces <= kMostTogether;
        if (!wanted(c) || !has_ears(counts[c]) || !fits) continue;
        chosen[c] = 1;
        together += faces;
    }
    return chosen;
}

namespace {

/// Halves edges of a mesh, the longest first. A face's longest edge is halved before its others, so no angle gets
/// small (Rivara 1984).
class EdgeSplitter {
 public:
    explicit EdgeSplitter(Mesh& mesh) : mesh_(mesh) {
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) add(f);
    }
    /// Whether an edge of this length or more was left to halve.
    bool halve_longest(double least) {
        while (!queue_.empty() && queue_.top().first >= least) {
            const Edge longest = queue_.top().second;
            queue_.pop();
            if (!faces_.contains(longest)) continue;
            halve(longest);
            return true;
        }
        return false;
    }
    /// Gives each vertex of a single face a third edge.
    void halve_opposite_ears() {
        std::vector<std::uint32_t> faces_at(mesh_.positions.size(), 0);
        for (const Face& face : mesh_.faces)
            for (const std::uint32_t v : face) ++faces_at[v];
        for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f)
            for (unsigned c = 0; c < 3; ++c) {
                const Face face = mesh_.faces[f];
                if (face[c] >= faces_at.size() || faces_at[face[c]] > 1) continue;
                faces_at[face[c]] = 2;
                halve(Edge(std::minmax(face[(c + 1) % 3], face[(c + 2) % 3])));
            }
    }

 private:
    using Edge = std::pair<std::uint32_t, std::uint32_t>;  // the smaller vertex first

    void halve(const Edge& edge) {
        const auto [a, b] = edge;
        const std::vector<std::uint32_t> around = faces_.at(edge);
        const auto m = static_cast<std::uint32_t>(mesh_.positions.size());
        mesh_.positions.push_back((mesh_.positions[a] + mesh_.positions[b]) * 0.5);
        append_vertex_data(mesh_, std::array{VertexShare{a, 0.5}, VertexShare{b, 0.5}}, mesh_);
        for (const std::uint32_t f : around) halve(f, a, b, m);
    }

    template <typename Visit>
    void visit_edges(std::uint32_t f, Visit visit) {
        const Face face = mesh_.faces[f];
        for (unsigned c = 0; c < 3; ++c) visit(Edge(std::minmax(face[c], face[(c + 1) % 3])));
    }
    void add(std::uint32_t f) {
        visit_edges(f, [&](const Edge& e) {
            std::vector<std::uint32_t>& faces = faces_[e];
            if (faces.empty()) queue_.emplace(length(mesh_.positions[e.first] - mesh_.positions[e.second]), e);
            faces.push_back(f);
        });
    }
    void remove(std::uint32_t f) {
        visit_edges(f, [&](const Edge& e) {
            const auto at = faces_.find(e);
            std::erase(at->second, f);
            if (at->second.empty()) faces_.erase(at);
        });
    }
    void halve(std::uint32_t f, std::uint32_t a, std::uint32_t b, std::uint32_t m) {
        remove(f);
        Face other = mesh_.faces[f];
        std::ranges::replace(mesh_.faces[f], b, m);
        std::ranges::replace(other, a, m);
        mesh_.faces.push_back(other);
        if (!mesh_.materials.empty()) mesh_.materials.push_back(mesh_.materials[f]);
        add(f);
        add(static_cast<std::uint32_t>(mesh_.faces.size() - 1));
    }

    Mesh& mesh_;
    std::map<Edge, std::vector<std::uint32_t>> faces_;  // of each edge
    std::priority_queue<std::pair<double, Edge>> queue_;
};

}  // namespace

void split_large_faces(Mesh& mesh, double longest) {
    const std::size_t most = mesh.faces.size() + mesh.faces.size() / 4 + 64;
    EdgeSplitter splitter(mesh);
    splitter.halve_opposite_ears();
    while (mesh.faces.size() < most && splitter.halve_longest(longest)) continue;
}

SemiRegularMesh facets_of(const Mesh& mesh) {
    SemiRegularMesh part;
    part.base = BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces).value();
    part.levels = 1;
    part.creases.assign(part.base.edge_count(), 1);  // boundaries, too: all the same cost next to nothing
    part.materials = mesh.materials;
    std::vector<std::uint32_t> same(mesh.faces.size());
    std::iota(same.begin(), same.end(), 0u);
    const std::vector<FacePoint> points = grid_points(part.base, part.levels, same);
    part.positions = positions_of(mesh, points);
    take_vertex_data(mesh, points, part);
    return part;
}

}  // namespace mvw
