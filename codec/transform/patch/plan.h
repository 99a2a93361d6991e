// Everything about one level of one mesh that the grid needs beside the regular kernels, worked out once: which ghosts
// copy from where, the edges and vertices that leave the regular rules, and their stencils as lists.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/transform/lifting.h"
#include "codec/transform/patch/layout.h"

namespace mvw {

/// Offsets into the level's vertex or detail planes. Vertices: patch f starts at f * 3 * plane, components are `plane`
/// apart. Details: patch f starts at f * 9 * plane with planes H, V, D for each component, components 3 * plane apart;
/// behind the patches lie the listed edges' details (LevelPlan::listed_slot).
struct Copy {
    std::uint32_t to, from;
};

/// Rows of a table by owning patch: those of patch f are [first[f], first[f + 1]).
using PatchRuns = std::vector<std::uint32_t>;

/// An edge whose stencils are lists: it touches a base vertex, or a boundary or crease. Its plane entry is zero while
/// the lift runs.
struct ListedEdge {
    std::uint32_t slot;       // of the owner's planes
    std::uint32_t ends[2];    // vertices
    std::uint32_t last_term;  // of terms; the first is the previous edge's last
    bool projected;           // SeededNormal speaks along the normal here
};
struct ListedTerm {
    std::uint32_t vertex;
    float position, shape;
};

/// A vertex that listed edges lift, beside what the kernel does; a base vertex, where a list does it all.
struct LiftTarget {
    std::uint32_t vertex;
    std::uint32_t last_source;
};
struct LiftSource {
    std::uint32_t detail;
    float weight;
};

/// A base vertex: where its ring lies.
struct Corner {
    std::uint32_t vertex;          // in its owner
    std::uint32_t last_triangle;   // of corner_triangles
    std::uint32_t last_neighbour;  // of corner_neighbours: whose mean makes x
    std::uint32_t last_loop_edge;  // of corner_loop_edges: detail slots whose sum Loop's even rule takes
    float loop_a = 1, loop_b = 0;
};

struct LevelPlan {
    unsigned level = 0;
    Layout layout{0};

    // Copies within one patch's planes from the planes of the neighbour across a side, by [side][its side][owned]:
    // border points of a side that is not owned, ghosts that lie inside the neighbour.
    std::array<std::array<std::array<std::vector<Copy>, 2>, 3>, 3> vertex_copies, edge_copies;
    // By side, on a boundary: ghost vertices fold back onto the side, so that the ring's area is that of the triangles
    // which exist; ghost edges are zero, as are those that touch a base vertex (its edges are listed).
    std::array<std::vector<Copy>, 3> folded_vertices;
    std::array<std::vector<std::uint32_t>, 3> zero_beyond;
    std::vector<std::uint32_t> zero_at_corners;
    // What those cannot name: copies between any planes, by patch. Vertex fixes include the corners.
    std::vector<Copy> vertex_fixes, edge_fixes;
    PatchRuns first_vertex_fix, first_edge_fix;

    std::vector<ListedEdge> listed;  // by owning patch, then in any order
    PatchRuns first_listed;
    std::vector<ListedTerm> terms;
    std::vector<LiftTarget> targets;  // by owning patch
    PatchRuns first_target;
    std::vector<LiftSource> sources;

    std::vector<Corner> corners;                                 // by base vertex
    std::vector<std::array<std::uint32_t, 2>> corner_triangles;  // the other two vertices of each
    std::vector<std::uint32_t> corner_neighbours, corner_loop_edges;

    /// Place of listed edge i's detail while its plane entry is zero.
    [[nodiscard]] std::uint32_t listed_slot(std::uint32_t i, std::uint32_t faces) const {
        const std::uint32_t block = 3 * layout.plane;
        return (faces + i / block) * 3 * block + i % block;
    }
    /// Floats of the detail planes.
    [[nodiscard]] std::size_t detail_floats(std::uint32_t faces) const {
        const std::size_t block = 3 * layout.plane;
        return (faces + (listed.size() + 1) / block + 1) * 3 * block + kPlanePadding;
    }
    /// A detail that is always zero.
    [[nodiscard]] std::uint32_t zero_slot(std::uint32_t faces) const {
        return listed_slot(static_cast<std::uint32_t>(listed.size()), faces);
    }
    [[nodiscard]] std::size_t vertex_floats(std::uint32_t faces) const {
        return std::size_t{faces} * 3 * layout.plane + kPlanePadding;
    }
};

/// Plans of the steps from level j to j + 1, j = 0 ... levels - 1.
std::vector<LevelPlan> make_plans(const GridTopology& topology, unsigned levels, const TransformOptions& options,
                                  std::span<const std::uint8_t> creases);

}  // namespace mvw
