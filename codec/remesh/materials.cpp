#include "codec/remesh/materials.h"

#include <algorithm>
#include <map>

#include "codec/mesh/half_edges.h"

namespace mvw {

namespace {

Face sorted(Face f) {
    std::ranges::sort(f);
    return f;
}

}  // namespace

void flag_material_borders(const Mesh& mesh, std::vector<std::uint8_t>& half_edges) {
    if (mesh.materials.empty()) return;
    const EdgeGroups groups = group_edges(mesh.faces, static_cast<std::uint32_t>(mesh.positions.size()));
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].size() != 2) continue;
        const std::uint32_t h = groups[g][0], twin = groups[g][1];
        if (mesh.materials[h / 3] != mesh.materials[twin / 3]) half_edges[h] = half_edges[twin] = 1;
    }
}

std::optional<std::vector<std::uint32_t>> materials_of(const Mesh& mesh, const Recognized& found) {
    std::vector<std::uint32_t> out;
    if (mesh.materials.empty()) return out;
    std::map<Face, std::uint32_t> material;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) material[sorted(mesh.faces[f])] = mesh.materials[f];
    const std::size_t of_base_face = std::size_t{1} << (2 * found.levels);
    const std::vector<Face> triangles = triangles_at_level(found.base, found.levels);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Face& f = triangles[t];
        const std::uint32_t label =
            material.at(sorted({found.vertices[f[0]], found.vertices[f[1]], found.vertices[f[2]]}));
        if (t % of_base_face == 0) out.push_back(label);
        if (label != out.back()) return std::nullopt;
    }
    return out;
}

}  // namespace mvw
