#include "codec/mesh/material_colors.h"

#include <algorithm>
#include <map>
#include <utility>

#include "codec/mesh/vertex_data.h"

namespace mvw {

const Rgba8* color_of(std::span<const MaterialColor> colors, std::uint32_t label) {
    const auto at = std::lower_bound(colors.begin(), colors.end(), label,
                                     [](const MaterialColor& c, std::uint32_t l) { return c.label < l; });
    return at != colors.end() && at->label == label ? &at->color : nullptr;
}

bool all_have_colors(std::span<const MaterialColor> colors, std::span<const std::uint32_t> labels) {
    if (labels.empty()) return color_of(colors, 0) != nullptr;
    return std::all_of(labels.begin(), labels.end(),
                       [&](std::uint32_t label) { return color_of(colors, label) != nullptr; });
}

void single_color_to_material(Mesh& mesh) {
    const std::vector<Rgba8>& colors = mesh.colors;
    if (colors.empty() || !mesh.materials.empty() || !mesh.material_colors.empty()) return;
    const auto is_it = [&](const Rgba8& c) { return c.a == 255 && c == colors[0]; };  // alpha of vertices is not shown
    if (!std::all_of(colors.begin(), colors.end(), is_it)) return;
    mesh.material_colors.push_back({0, colors[0]});
    mesh.colors.clear();
}

std::vector<std::uint32_t> colors_to_vertices(Mesh& mesh) {
    std::vector<std::uint32_t> copied;
    if (mesh.material_colors.empty()) return copied;
    const std::vector<MaterialColor> materials = std::move(mesh.material_colors);
    mesh.material_colors.clear();
    const std::size_t vertices = mesh.positions.size();
    mesh.colors.resize(vertices);
    const std::vector<Rgba8> own = mesh.colors;
    std::vector<std::uint8_t> painted(vertices, 0);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;  // by vertex and colour
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Rgba8* of_material = color_of(materials, mesh.materials.empty() ? 0 : mesh.materials[f]);
        for (std::uint32_t& v : mesh.faces[f]) {
            const Rgba8 color = of_material != nullptr ? *of_material : own[v];
            if (painted[v] == 0 || mesh.colors[v] == color) {
                painted[v] = 1;
                mesh.colors[v] = color;
                continue;
            }
            const std::uint32_t key = std::uint32_t{color.r} << 24 | std::uint32_t{color.g} << 16 |
                                      std::uint32_t{color.b} << 8 | std::uint32_t{color.a};
            const auto known = copies.find({v, key});
            if (known == copies.end() && copied.size() == vertices) continue;
            if (known != copies.end()) {
                v = known->second;
                continue;
            }
            const auto copy = static_cast<std::uint32_t>(mesh.positions.size());
            copies.emplace(std::pair{v, key}, copy);
            copied.push_back(v);
            mesh.positions.push_back(mesh.positions[v]);
            append_vertex_data(mesh, v, mesh);
            mesh.colors.back() = color;
            v = copy;
        }
    }
    return copied;
}

}  // namespace mvw
