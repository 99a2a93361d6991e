#include "client/drawable.h"

#include <algorithm>

#include "codec/mesh/material_colors.h"
#include "codec/mesh/normals.h"
#include "codec/mesh/solid.h"

namespace mvw::client {
namespace {

void set_positions(const Mesh& mesh, const Vec3& origin, Drawable& out) {
    out.positions.reserve(mesh.positions.size());
    for (const Vec3& p : mesh.positions) out.positions.push_back(to_float(p - origin));
}

/// Those that the file has, else the surface's.
void set_normals(const Mesh& mesh, Drawable& out) {
    out.normals.reserve(mesh.positions.size());
    for (const VertexField& field : mesh.fields)
        if (field.kind == FieldKind::Normals)
            for (std::size_t k = 0; k < field.values.size(); k += 3)
                out.normals.push_back(to_float({field.values[k], field.values[k + 1], field.values[k + 2]}));
    if (!out.normals.empty()) return;
    for (const Vec3& n : vertex_normals(mesh.positions, mesh.faces)) out.normals.push_back(to_float(n));
}

/// Vertex at t of 2^level along base edge e (semi_regular.h).
std::uint32_t edge_vertex(const BaseMesh& base, unsigned level, std::uint32_t e, std::uint32_t t) {
    const std::uint32_t n = 1u << level;
    if (t == 0 || t == n) return base.edges()[e].v[t == 0 ? 0 : 1];
    while (t % 2 == 0) t /= 2, --level;
    return static_cast<std::uint32_t>(vertices_at_level(base, level - 1)) + e * (1u << (level - 1)) + t / 2;
}

void add_edge_lines(const BaseMesh& base, unsigned level, std::uint32_t first_vertex, bool boundary_only,
                    std::vector<std::uint32_t>& lines) {
    for (std::uint32_t e = 0; e < base.edge_count(); ++e) {
        if (boundary_only && base.edges()[e].face[1] != kNone) continue;
        for (std::uint32_t t = 0; t < 1u << level; ++t) {
            lines.push_back(first_vertex + edge_vertex(base, level, e, t));
            lines.push_back(first_vertex + edge_vertex(base, level, e, t + 1));
        }
    }
}

/// Each inner edge runs once in each direction: the rising one is taken. Boundaries are base edges. Edges at copies of
/// vertices (from `first_copy` on, where two colours meet) are taken as often as they come.
void add_inner_edges(const std::vector<std::uint32_t>& triangles, std::uint32_t first_copy,
                     std::vector<std::uint32_t>& lines) {
    for (std::size_t t = 0; t < triangles.size(); t += 3)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = triangles[t + k], b = triangles[t + (k + 1) % 3];
            if (a < b || a >= first_copy) lines.insert(lines.end(), {a, b});
        }
}

}  // namespace

Result<Drawable> make_drawable(const Decoder& decoder, const DrawableOptions& options) {
    Result<Mesh> mesh = decoder.mesh(options.level);
    if (!mesh.ok()) return mesh.error();
    const FileHeader& header = *decoder.header();
    Drawable out;
    set_positions(*mesh, {header.center[0], header.center[1], header.center[2]}, out);
    set_normals(*mesh, out);
    std::uint32_t first_vertex = 0;
    for (std::size_t part = 0; part < header.parts.size(); ++part) {
        const BaseMesh* base = decoder.base(part);
        if (base == nullptr) continue;
        const unsigned level = std::min(options.level, decoder.finest_level(part));
        out.level = std::max(out.level, level);
        if (!decoder.shows(part, options.level)) continue;
        out.parts += part >= header.main_parts() ? static_cast<std::uint32_t>(part) + 1 : 1;
        out.solid =
            (out.solid || first_vertex == 0) && bounds_solids(*base, std::span(mesh->positions).subspan(first_vertex));
        if (options.base_edges) add_edge_lines(*base, level, first_vertex, false, out.base_edges);
        if (options.edges) add_edge_lines(*base, level, first_vertex, true, out.edges);
        first_vertex += static_cast<std::uint32_t>(vertices_at_level(*base, level));
    }
    // Copies between two colours have the normal of what they copy.
    for (const std::uint32_t v : colors_to_vertices(*mesh)) {
        out.positions.push_back(Vec3f(out.positions[v]));
        out.normals.push_back(Vec3f(out.normals[v]));
    }
    out.colors = std::move(mesh->colors);
    out.triangles.reserve(mesh->faces.size() * 3);
    for (const Face& f : mesh->faces) out.triangles.insert(out.triangles.end(), f.begin(), f.end());
    if (options.edges) add_inner_edges(out.triangles, first_vertex, out.edges);
    return out;
}

}  // namespace mvw::client
