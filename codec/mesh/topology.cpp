// The checks and counts that clean.h declares for clean meshes.
#include <cmath>
#include <numeric>
#include <utility>

#include "codec/mesh/clean.h"
#include "codec/mesh/disjoint_sets.h"
#include "codec/mesh/half_edges.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {
namespace {

/// The first fault of the mesh's arrays, or an empty string.
std::string fault_of_arrays(const Mesh& mesh) {
    const std::size_t V = mesh.positions.size();
    if (!mesh.colors.empty() && mesh.colors.size() != V) return "the number of colours is not that of vertices";
    if (!mesh.materials.empty() && mesh.materials.size() != mesh.faces.size())
        return "the number of materials is not that of faces";
    for (const VertexField& field : mesh.fields)
        if (field.values.size() != V * field.components()) return "a field's values are not those of all vertices";
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Face& face = mesh.faces[f];
        for (const std::uint32_t v : face)
            if (v >= V) return "face " + std::to_string(f) + " has an index out of range";
        if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0])
            return "face " + std::to_string(f) + " repeats a vertex";
    }
    for (std::size_t v = 0; v < V; ++v)
        if (const Vec3& p = mesh.positions[v]; !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return "vertex " + std::to_string(v) + " is not finite";
    return {};
}

std::string fault_of_connectivity(const Mesh& mesh) {
    const auto V = static_cast<std::uint32_t>(mesh.positions.size());
    std::vector<std::uint32_t> mates(3 * mesh.faces.size(), kNone);
    const EdgeGroups edges = group_edges(mesh.faces, V);
    for (std::size_t g = 0; g < edges.size(); ++g) {
        const auto sides = edges[g];
        if (sides.size() == 1) continue;
        if (sides.size() > 2 || origin(mesh.faces, sides[0]) == origin(mesh.faces, sides[1]))
            return "the edge on side " + std::to_string(sides[0] % 3) + " of face " + std::to_string(sides[0] / 3) +
                   " has two faces of one direction";
        mates[sides[0]] = sides[1];
        mates[sides[1]] = sides[0];
    }
    const Fans fans = find_fans(mates);
    std::vector<std::uint32_t> fan_of_vertex(V, kNone);
    for (std::uint32_t c = 0; c < mates.size(); ++c) {
        std::uint32_t& fan = fan_of_vertex[origin(mesh.faces, c)];
        if (fan == kNone) fan = fans.of_corner[c];
        if (fan != fans.of_corner[c])
            return "the faces around vertex " + std::to_string(origin(mesh.faces, c)) + " are not one fan";
    }
    for (std::uint32_t v = 0; v < V; ++v)
        if (fan_of_vertex[v] == kNone) return "vertex " + std::to_string(v) + " is in no face";
    return {};
}

/// Counts the loops that boundary edges form, each to its component, given where each boundary vertex leads.
void count_loops(std::vector<std::uint32_t> next, std::span<const std::uint32_t> component_of_vertex,
                 std::vector<Component>& parts) {
    for (std::uint32_t v = 0; v < next.size(); ++v) {
        if (next[v] == kNone) continue;
        ++parts[component_of_vertex[v]].boundary_loops;
        for (std::uint32_t at = v; next[at] != kNone;) at = std::exchange(next[at], kNone);
    }
}

}  // namespace

bool is_clean_manifold(const Mesh& mesh, std::string* why) {
    std::string fault = fault_of_arrays(mesh);
    if (fault.empty()) fault = fault_of_connectivity(mesh);
    if (why != nullptr) *why = fault;
    return fault.empty();
}

std::vector<Component> components(const Mesh& mesh, std::vector<std::uint32_t>& component_of_face) {
    const auto V = static_cast<std::uint32_t>(mesh.positions.size());
    std::vector<std::uint32_t> parent(V);
    std::iota(parent.begin(), parent.end(), 0u);
    for (const Face& f : mesh.faces)
        for (const std::uint32_t v : {f[1], f[2]}) unite(parent, f[0], v);

    std::vector<Component> parts;
    std::vector<std::uint32_t> component_of_vertex(V, kNone);
    component_of_face.clear();
    for (const Face& f : mesh.faces) {
        std::uint32_t& number = component_of_vertex[find_root(parent, f[0])];
        if (number == kNone) {
            number = static_cast<std::uint32_t>(parts.size());
            parts.emplace_back();
        }
        ++parts[number].faces;
        component_of_face.push_back(number);
    }
    for (std::uint32_t v = 0; v < V; ++v) {
        component_of_vertex[v] = component_of_vertex[find_root(parent, v)];
        if (component_of_vertex[v] != kNone) ++parts[component_of_vertex[v]].vertices;
    }

    const EdgeGroups edges = group_edges(mesh.faces, V);
    std::vector<std::uint32_t> next(V, kNone);
    for (std::size_t g = 0; g < edges.size(); ++g) {
        const std::uint32_t h = edges[g][0];
        ++parts[component_of_face[h / 3]].edges;
        if (edges[g].size() == 1) next[origin(mesh.faces, h)] = origin(mesh.faces, next_half_edge(h));
    }
    count_loops(std::move(next), component_of_vertex, parts);
    for (Component& c : parts) {
        const int euler = static_cast<int>(c.vertices) - static_cast<int>(c.edges) + static_cast<int>(c.faces);
        c.genus = (2 - static_cast<int>(c.boundary_loops) - euler) / 2;
    }
    return parts;
}

}  // namespace mvw
