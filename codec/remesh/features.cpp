#include "codec/remesh/features.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "codec/mesh/disjoint_sets.h"
#include "codec/mesh/half_edges.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

namespace {

constexpr unsigned kLeastLoop = 6;    // edges of a closed loop that is no accident
constexpr double kMostBesideDeg = 9;  // mean angle at the other edges of a feature's faces; on noise it is larger

/// A sharp edge and its two half-edges.
struct SharpEdge {
    std::uint32_t a, b;  // vertices
    std::uint32_t half_edge, twin;
    double length;
    double beside_deg;  // mean angle at the other edges of its faces that are not sharp themselves
    bool kept = true;
};

/// Degrees between the faces at each half-edge; 0 at boundaries and at faces without area: those say nothing.
std::vector<float> edge_angles(const Mesh& mesh, const EdgeGroups& groups) {
    std::vector<Vec3> normals;
    normals.reserve(mesh.faces.size());
    for (const Face& f : mesh.faces) {
        const Vec3& a = mesh.positions[f[0]];
        normals.push_back(normalized(cross(mesh.positions[f[1]] - a, mesh.positions[f[2]] - a)));
    }
    std::vector<float> angles(mesh.faces.size() * 3, 0);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].size() != 2) continue;
        const Vec3 &n0 = normals[groups[g][0] / 3], &n1 = normals[groups[g][1] / 3];
        if (squared_length(n0) == 0 || squared_length(n1) == 0) continue;
        const double angle = std::acos(std::clamp(dot(n0, n1), -1.0, 1.0)) * 180 / std::numbers::pi;
        angles[groups[g][0]] = angles[groups[g][1]] = static_cast<float>(angle);
    }
    return angles;
}

std::vector<SharpEdge> sharp_edges(const Mesh& mesh, double angle_deg) {
    const EdgeGroups groups = group_edges(mesh.faces, static_cast<std::uint32_t>(mesh.positions.size()));
    const std::vector<float> angles = edge_angles(mesh, groups);
    std::vector<SharpEdge> edges;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].size() != 2) continue;
        const std::uint32_t h = groups[g][0], twin = groups[g][1];
        if (angles[h] <= angle_deg) continue;
        double sum = 0;
        int count = 0;
        for (const std::uint32_t first : {h, twin}) {
            for (std::uint32_t o = next_half_edge(first); o != first; o = next_half_edge(o))
                if (angles[o] <= angle_deg) sum += angles[o], ++count;
        }
        const std::uint32_t a = origin(mesh.faces, h), b = origin(mesh.faces, next_half_edge(h));
        edges.push_back({a, b, h, twin, length(mesh.positions[a] - mesh.positions[b]), count > 0 ? sum / count : 0});
    }
    return edges;
}

/// The kept edges at each vertex.
class EdgesAtVertex {
 public:
    EdgesAtVertex(const std::vector<SharpEdge>& edges, std::size_t vertices) : begin_(vertices + 1, 0) {
        for (const SharpEdge& e : edges)
            if (e.kept) ++begin_[e.a + 1], ++begin_[e.b + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        edges_.resize(begin_.back());
        std::vector<std::uint32_t> at(begin_.begin(), begin_.end() - 1);
        for (std::uint32_t k = 0; k < edges.size(); ++k)
            if (edges[k].kept) edges_[at[edges[k].a]++] = k, edges_[at[edges[k].b]++] = k;
    }
    [[nodiscard]] std::size_t degree(std::uint32_t v) const { return begin_[v + 1] - begin_[v]; }
    [[nodiscard]] std::span<const std::uint32_t> at(std::uint32_t v) const {
        return std::span(edges_).subspan(begin_[v], degree(v));
    }

 private:
    std::vector<std::uint32_t> begin_, edges_;
};

/// Drops curves (runs of edges between vertices where not just two meet) that end freely and are short.
void drop_loose_ends(const Mesh& mesh, double min_length, std::vector<SharpEdge>& edges) {
    const EdgesAtVertex around(edges, mesh.positions.size());
    std::vector<std::uint32_t> run;
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        if (around.degree(v) != 1) continue;
        run.clear();
        double total = 0;
        std::uint32_t at = v, edge = around.at(v)[0];
        while (true) {
            run.push_back(edge);
            total += edges[edge].length;
            at = edges[edge].a == at ? edges[edge].b : edges[edge].a;
            if (around.degree(at) != 2) break;
            edge = around.at(at)[0] == edge ? around.at(at)[1] : around.at(at)[0];
        }
        if (total >= min_length) continue;
        for (const std::uint32_t k : run) edges[k].kept = false;
    }
}

/// Drops whole groups of connected curves that noise may have drawn: where the surface beside them is rough, too, and
/// where their length together is small, clean closed loops (the rim of a drilled hole) aside.
void drop_noise(const Mesh& mesh, double min_group, std::vector<SharpEdge>& edges) {
    std::vector<std::uint32_t> parent(mesh.positions.size());
    std::iota(parent.begin(), parent.end(), 0u);
    for (const SharpEdge& e : edges)
        if (e.kept) unite(parent, e.a, e.b);
    const EdgesAtVertex around(edges, mesh.positions.size());
    struct Group {
        double length = 0, beside_deg = 0;
        unsigned edges = 0;
        bool closed_loop = true;
    };
    std::vector<Group> groups(mesh.positions.size());
    for (const SharpEdge& e : edges) {
        if (!e.kept) continue;
        Group& group = groups[find_root(parent, e.a)];
        group.length += e.length;
        group.beside_deg += e.beside_deg;
        ++group.edges;
        group.closed_loop &= around.degree(e.a) == 2 && around.degree(e.b) == 2;
    }
    for (SharpEdge& e : edges) {
        if (!e.kept) continue;
        const Group& group = groups[find_root(parent, e.a)];
        e.kept = group.beside_deg <= kMostBesideDeg * group.edges &&
                 (group.length >= min_group || (group.closed_loop && group.edges >= kLeastLoop));
    }
}

/// Sets the flags of both halves of each edge between two materials.
void flag_material_borders(const Mesh& mesh, std::vector<std::uint8_t>& flags) {
    if (mesh.materials.empty()) return;
    const EdgeGroups groups = group_edges(mesh.faces, static_cast<std::uint32_t>(mesh.positions.size()));
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].size() != 2) continue;
        const std::uint32_t h = groups[g][0], twin = groups[g][1];
        if (mesh.materials[h / 3] != mesh.materials[twin / 3]) flags[h] = flags[twin] = 1;
    }
}

}  // namespace

std::vector<std::uint8_t> feature_half_edges(const Mesh& mesh, const FeatureOptions& options) {
    std::vector<SharpEdge> edges = sharp_edges(mesh, options.angle_deg);
    const double diagonal = bounding_box(mesh).diagonal();
    // Each round may free new ends where curves met.
    for (int round = 0; round < 3; ++round) drop_loose_ends(mesh, options.min_length * diagonal, edges);
    drop_noise(mesh, options.min_group * diagonal, edges);
    std::vector<std::uint8_t> flags(mesh.faces.size() * 3, 0);
    for (const SharpEdge& e : edges)
        if (e.kept) flags[e.half_edge] = flags[e.twin] = 1;
    flag_material_borders(mesh, flags);
    return flags;
}

}  // namespace mvw
