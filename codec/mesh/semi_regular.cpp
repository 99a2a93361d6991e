#include "codec/mesh/semi_regular.h"

#include <unordered_map>

#include <string>

namespace mvw {

namespace {

std::uint64_t directed_key(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{a} << 32) | b;
}

Error bad_face(std::size_t f, const char* why) {
    return {Errc::Malformed, 0, "base face " + std::to_string(f) + " " + why};
}

/// Index of the point at grid parameter t (of 2^level) along side s of face f, both t and 2^level - t above 0 and odd.
std::uint32_t odd_edge_point(const BaseMesh& base, std::uint32_t f, unsigned s, unsigned level, std::uint32_t t) {
    const std::uint32_t n = 1u << level;
    const std::uint32_t along = base.runs_along(f, s) ? t : n - t;
    const std::uint64_t start = vertices_at_level(base, level - 1);
    return static_cast<std::uint32_t>(start + std::uint64_t{base.edge_of(f, s)} * (n / 2) + along / 2);
}

}  // namespace

Result<BaseMesh> BaseMesh::create(std::uint32_t vertex_count, std::vector<Face> faces) {
    BaseMesh base;
    base.vertex_count_ = vertex_count;
    base.face_edges_.resize(faces.size());
    std::unordered_map<std::uint64_t, std::uint32_t> edge_by_direction;
    edge_by_direction.reserve(faces.size() * 2);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const Face& face = faces[f];
        if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) return bad_face(f, "repeats a vertex");
        for (std::uint8_t s = 0; s < 3; ++s) {
            const std::uint32_t a = face[s], b = face[(s + 1u) % 3];
            if (a >= vertex_count) return bad_face(f, "has a vertex index out of range");
            if (const auto twin = edge_by_direction.find(directed_key(b, a)); twin != edge_by_direction.end()) {
                BaseEdge& edge = base.edges_[twin->second];
                if (edge.face[1] != kNone) return bad_face(f, "is the third at an edge");
                edge.face[1] = static_cast<std::uint32_t>(f);
                edge.side[1] = s;
                base.face_edges_[f][s] = twin->second;
                continue;
            }
            const auto index = static_cast<std::uint32_t>(base.edges_.size());
            if (!edge_by_direction.emplace(directed_key(a, b), index).second)
                return bad_face(f, "runs through an edge in the same direction as its neighbour");
            base.edges_.push_back({{a, b}, {static_cast<std::uint32_t>(f), kNone}, {s, 0}});
            base.face_edges_[f][s] = index;
        }
    }
    base.faces_ = std::move(faces);
    return base;
}

std::uint32_t vertex_index(const BaseMesh& base, std::uint32_t f, unsigned level, std::uint32_t i, std::uint32_t k) {
    while (level > 0 && i % 2 == 0 && k % 2 == 0) i /= 2, k /= 2, --level;
    const std::uint32_t n = 1u << level;
    const Face& face = base.faces()[f];
    if (level == 0) return i == 1 ? face[1] : k == 1 ? face[2] : face[0];
    if (k == 0) return odd_edge_point(base, f, 0, level, i);
    if (i + k == n) return odd_edge_point(base, f, 1, level, k);
    if (i == 0) return odd_edge_point(base, f, 2, level, n - k);
    const std::uint64_t run = interior_points(level) - interior_points(level - 1);
    return static_cast<std::uint32_t>(vertices_at_level(base, level - 1) + std::uint64_t{base.edge_count()} * (n / 2) +
                                      f * run + interior_rank(level, i, k));
}

std::uint32_t edge_vertex_index(const BaseMesh& base, const BaseEdge& edge, unsigned level, std::uint32_t t) {
    const std::uint32_t n = 1u << level;
    const std::uint32_t i = edge.side[0] == 0 ? t : edge.side[0] == 1 ? n - t : 0;
    const std::uint32_t k = edge.side[0] == 0 ? 0 : edge.side[0] == 1 ? t : n - t;
    return vertex_index(base, edge.face[0], level, i, k);
}

void patch_vertices(const BaseMesh& base, std::uint32_t f, unsigned level, std::vector<std::uint32_t>& out) {
    const std::uint32_t n = 1u << level;
    out.resize(std::size_t{n + 1} * (n + 2) / 2);
    const auto at = [&](std::uint32_t i, std::uint32_t k) -> std::uint32_t& {
        return out[patch_place(n, i, k)];
    };
    const Face& face = base.faces()[f];
    at(0, 0) = face[0], at(n, 0) = face[1], at(0, n) = face[2];
    // What each level adds lies in runs: along the three sides, then inside.
    for (unsigned j = 1; j <= level; ++j) {
        const std::uint32_t points = 1u << j, step = n >> j;
        const auto start = static_cast<std::uint32_t>(vertices_at_level(base, j - 1));
        for (std::uint32_t t = 1; t < points; t += 2) {
            const std::uint32_t a = t * step, b = n - a;
            at(a, 0) = odd_edge_point(base, f, 0, j, t);
            at(b, a) = odd_edge_point(base, f, 1, j, t);
            at(0, b) = odd_edge_point(base, f, 2, j, t);
        }
        const auto run = static_cast<std::uint32_t>(interior_points(j) - interior_points(j - 1));
        std::uint32_t next = start + base.edge_count() * (points / 2) + f * run;
        for (std::uint32_t i = 1; i < points; ++i) {
            std::uint32_t* const row = &at(i * step, 0);
            for (std::uint32_t k = 1; i + k < points; k += i % 2 == 1 ? 1 : 2) row[k * step] = next++;
        }
    }
}

std::vector<Face> triangles_at_level(const BaseMesh& base, unsigned level) {
    const std::uint32_t n = 1u << level;
    std::vector<Face> triangles(std::size_t{base.face_count()} << (2 * level));
    std::vector<std::uint32_t> patch;
    Face* to = triangles.data();
    for (std::uint32_t f = 0; f < base.face_count(); ++f) {
        patch_vertices(base, f, level, patch);
        const std::uint32_t* row = patch.data();
        for (std::uint32_t length = n + 1; length > 1; --length) {
            const std::uint32_t* const next = row + length;
            for (std::uint32_t k = 0; k + 2 < length; ++k) {
                *to++ = {row[k], next[k], row[k + 1]};
                *to++ = {next[k], next[k + 1], row[k + 1]};
            }
            *to++ = {row[length - 2], next[length - 2], row[length - 1]};
            row = next;
        }
    }
    return triangles;
}

std::vector<std::uint8_t> line_vertices(const SemiRegularMesh& mesh) {
    std::vector<std::uint8_t> flags(vertices_at_level(mesh.base, mesh.levels), 0);
    const std::uint32_t n = 1u << mesh.levels;
    for (std::uint32_t b = 0; b < mesh.base.edge_count(); ++b) {
        const BaseEdge& e = mesh.base.edges()[b];
        const bool crease = !mesh.creases.empty() && mesh.creases[b] != 0;
        const bool border =
            e.face[1] != kNone && !mesh.materials.empty() && mesh.materials[e.face[0]] != mesh.materials[e.face[1]];
        if (e.face[1] != kNone && !crease && !border) continue;
        for (std::uint32_t t = 0; t <= n; ++t) flags[edge_vertex_index(mesh.base, e, mesh.levels, t)] = 1;
    }
    return flags;
}

Mesh finest_mesh(std::span<const SemiRegularMesh> parts) {
    Mesh out;
    for (const SemiRegularMesh& part : parts) {
        const auto first = static_cast<std::uint32_t>(out.positions.size());
        out.positions.insert(out.positions.end(), part.positions.begin(), part.positions.end());
        for (const Face& f : triangles_at_level(part.base, part.levels))
            out.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    }
    return out;
}

}  // namespace mvw
