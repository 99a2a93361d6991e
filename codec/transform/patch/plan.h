// Everything about one level of one mesh that the grid needs beside the regular kernels, worked out once: which ghosts
// copy from where, the edges and vertices that leave the regular rules, and their stencils as lists.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/transform/lifting.h"
#include "codec/transform/patch/kernels.h"
#include "codec/transform/patch/layout.h"

namespace mvw {

/// Rows of a table by owning patch: those of patch f are [first[f], first[f + 1]).
using PatchRuns = std::vector<std::uint32_t>;

/// A base vertex: where its ring lies.
struct Corner {
    std::uint32_t vertex;          // in its owner; kNone where no face has it
    std::uint32_t last_triangle;   // of corner_triangles
    std::uint32_t last_neighbour;  // of corner_neighbours: whose mean makes x
    std::uint32_t last_loop_edge;  // of corner_loop_edges: details whose sum Loop's even rule takes
    float loop_a = 1, loop_b = 0;
    float vector_even = 0;  // its weight in the vector transform's even rule, relative to a regular vertex'
};

struct LevelPlan {
    unsigned level = 0;
    Layout layout{0, 1};
    LiftProgram lift_program;

    // Between a patch and its neighbour across a side, by [side][its side], offsets within each: vertices of the side,
    // and ghosts with the neighbour's inner vertices that they stand for. Those near corners are in `fixes`.
    std::array<std::array<std::vector<Copy>, 3>, 3> side_vertices, ghosts;
    // Offsets of the n + 1 vertices and n edges of each side, from its first corner on.
    std::array<std::vector<std::uint32_t>, 3> side_points, side_edges;
    // By side, on a boundary: ghosts fold back onto the side, so that the ring's area is that of the triangles which
    // exist.
    std::array<std::vector<Copy>, 3> folded;
    // What those cannot name: copies between any patches, by the patch of `to`; base vertices among them. Which of them
    // are from a patch, where their shares of the lift are collected.
    std::vector<Copy> fixes;
    std::vector<std::uint32_t> collected_fixes;
    PatchRuns first_fix, first_collected_fix;

    // Places of the floats of runs in hierarchical order (Kernels::load_runs): of a face's details, and of its vertices
    // born on levels 1 ... level; the same of each side.
    using Places = std::vector<std::uint32_t>;
    Places detail_places;
    std::vector<Places> vertex_places;
    std::array<Places, 3> side_detail_places;
    std::array<std::vector<Places>, 3> side_vertex_places;

    std::vector<ListedEdge> listed;  // by owning patch, then in any order
    PatchRuns first_listed;
    std::vector<std::uint32_t> listed_vertices;
    std::vector<float> listed_weights;
    std::vector<LiftTarget> targets;  // by owning patch
    PatchRuns first_target;
    std::vector<std::uint32_t> sources;  // listed edges
    std::vector<float> source_weights;

    std::vector<Corner> corners;                                 // by base vertex
    std::vector<std::array<std::uint32_t, 2>> corner_triangles;  // the other two vertices of each
    std::vector<std::uint32_t> corner_neighbours;
    std::vector<std::uint32_t> corner_loop_edges;  // among all groups' details

    [[nodiscard]] ListedEdges listed_edges(std::uint32_t f) const;
    [[nodiscard]] LiftTargets lift_targets(std::uint32_t f) const;

    /// Where a patch starts.
    [[nodiscard]] std::size_t patch_vertices(std::uint32_t f) const {
        return std::size_t{f / layout.lanes} * layout.vertex_floats + f % layout.lanes;
    }
    [[nodiscard]] std::size_t patch_edges(std::uint32_t f) const {
        return std::size_t{f / layout.lanes} * layout.edge_floats + f % layout.lanes;
    }
    /// Bytes of all the tables.
    [[nodiscard]] std::size_t memory_bytes() const;
};

}  // namespace mvw
