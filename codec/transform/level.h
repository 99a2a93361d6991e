// Connectivity of one level of a semi-regular mesh, explicit: half-edges, edges, and what each vertex touches. Serves
// the reference transform, the weights near irregular vertices and tests; the production grid never builds a fine one.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/semi_regular.h"

namespace mvw {

/// The ten-point stencil of an edge (v1, v2); kNone where a point does not exist (wings do not reach over a crease).
/// Points may repeat on tiny bases.
///
///            w0 ──── o0 ──── w1
///           /  \    /  \    /  \       o0 lies left of the edge's direction v1 -> v2
///         f0 ── v1 ── e ── v2 ── f1
///           \  /    \  /    \  /
///            w2 ──── o1 ──── w3
struct TenPoints {
    std::array<std::uint32_t, 2> ends, opp;
    std::array<std::uint32_t, 4> wings;
    std::array<std::uint32_t, 2> far;  // only beyond regular ends
};

/// Half-edge h = 3 f + s runs through face f from its corner s to corner s + 1.
struct Level {
    struct Edge {
        std::uint32_t half;  // the half-edge that runs in the edge's direction
        std::uint32_t odd;   // hierarchical index of the vertex that splits it on the next level
        bool sharp;          // boundary, or along a crease
    };
    std::uint32_t vertex_count = 0;
    std::vector<Face> faces;
    std::vector<std::uint32_t> twin;     // of each half-edge; kNone on a boundary
    std::vector<std::uint32_t> edge_of;  // of each half-edge
    std::vector<Edge> edges;
    std::vector<std::uint32_t> valence;      // of each vertex: its edges
    std::vector<std::uint32_t> sharp_edges;  // of each vertex: its sharp edges
    std::vector<std::uint32_t> first_edge;   // V + 1: where each vertex' edges start in vertex_edges
    std::vector<std::uint32_t> vertex_edges;

    static constexpr std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static constexpr std::uint32_t prev(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    [[nodiscard]] std::uint32_t from(std::uint32_t h) const { return faces[h / 3][h % 3]; }
    [[nodiscard]] std::uint32_t to(std::uint32_t h) const { return from(next(h)); }
    [[nodiscard]] std::uint32_t tip(std::uint32_t h) const { return from(prev(h)); }

    /// Inside, on no crease, six edges.
    [[nodiscard]] bool regular(std::uint32_t v) const { return sharp_edges[v] == 0 && valence[v] == 6; }
    /// On a boundary or crease.
    [[nodiscard]] bool sharp(std::uint32_t v) const { return sharp_edges[v] != 0; }
    /// On exactly one curve of sharp edges, which passes through; other sharp vertices are corners.
    [[nodiscard]] bool on_curve(std::uint32_t v) const { return sharp_edges[v] == 2; }
    [[nodiscard]] std::span<const std::uint32_t> edges_at(std::uint32_t v) const {
        return {vertex_edges.data() + first_edge[v], first_edge[v + 1] - first_edge[v]};
    }
    [[nodiscard]] std::uint32_t other_end(std::uint32_t edge, std::uint32_t v) const {
        const std::uint32_t h = edges[edge].half;
        return from(h) == v ? to(h) : from(h);
    }
    /// The two neighbours of v along its curve; v must be on_curve().
    [[nodiscard]] std::array<std::uint32_t, 2> curve_neighbours(std::uint32_t v) const;
    [[nodiscard]] TenPoints ten_points(std::uint32_t edge) const;
};

/// Level j of a base mesh. An edge is directed as the upright triangle (i,k) (i+1,k) (i,k+1) of its face runs through
/// it, on a base edge as that base edge is. creases: empty, or a flag for each base edge. O(4^j F).
Level make_level(const BaseMesh& base, unsigned level, std::span<const std::uint8_t> creases);

}  // namespace mvw
