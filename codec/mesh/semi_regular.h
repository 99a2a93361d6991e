// Semi-regular meshes: a base mesh whose every triangle carries a regular triangular grid, and the one order in which
// remesher, transform, coder and decoder name its vertices.
//
// Grid of one base face at level j, n = 2^j: vertex (i, k) with i, k >= 0 and i + k <= n has barycentric weights
// (n-i-k, i, k)/n over the face's corners 0, 1, 2. Side s runs from corner s to corner s+1 (mod 3):
//
//        2 (0,n)              side 0: k = 0,      t = i
//        | \                  side 1: i + k = n,  t = k
//  side 2|  \ side 1          side 2: i = 0,      t = n - k
//        0 - 1 (n,0)
//         side 0
//
// Hierarchical order: the V(j) vertices of level j come first in those of every finer level. Behind the base vertices,
// each level j >= 1 appends its new (odd) vertices: for each base edge in order the 2^(j-1) points at odd t (counted
// along the edge's direction), then for each base face its new interior points, rows of rising i, in a row rising k.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

inline constexpr std::uint32_t kNone = 0xFFFFFFFFu;

/// An edge of the base mesh, directed as its first face runs through it.
struct BaseEdge {
    std::array<std::uint32_t, 2> v{};                 // from, to
    std::array<std::uint32_t, 2> face{kNone, kNone};  // face[1] is kNone on a boundary and runs through it backwards
    std::array<std::uint8_t, 2> side{0, 0};           // which side of that face
};

/// Connectivity of level 0: an oriented manifold, possibly with boundary and of several components, in which two
/// vertices are joined by at most one edge. Edges are in order of first appearance, faces by number, sides 0 to 2.
class BaseMesh {
 public:
    BaseMesh() = default;
    /// Malformed where an edge has over two faces or two of one direction, a face repeats a vertex, or an index is
    /// not below vertex_count. O(F).
    static Result<BaseMesh> create(std::uint32_t vertex_count, std::vector<Face> faces);

    [[nodiscard]] std::uint32_t vertex_count() const { return vertex_count_; }
    [[nodiscard]] std::uint32_t edge_count() const { return static_cast<std::uint32_t>(edges_.size()); }
    [[nodiscard]] std::uint32_t face_count() const { return static_cast<std::uint32_t>(faces_.size()); }
    [[nodiscard]] const std::vector<Face>& faces() const { return faces_; }
    [[nodiscard]] const std::vector<BaseEdge>& edges() const { return edges_; }
    /// Edge on side s of face f.
    [[nodiscard]] std::uint32_t edge_of(std::uint32_t f, unsigned s) const { return face_edges_[f][s]; }
    /// A side of a face; face is kNone where there is none.
    struct Side {
        std::uint32_t face;
        unsigned side;
    };
    /// Side s of face f as the face beyond has it.
    [[nodiscard]] Side beyond(std::uint32_t f, unsigned s) const {
        const BaseEdge& e = edges_[face_edges_[f][s]];
        const unsigned other = runs_along(f, s) ? 1 : 0;
        return {e.face[other], e.side[other]};
    }
    /// True where side s of face f runs along its edge's direction (always so for the edge's first face).
    [[nodiscard]] bool runs_along(std::uint32_t f, unsigned s) const {
        const BaseEdge& e = edges_[face_edges_[f][s]];
        return e.face[0] == f && e.side[0] == s;
    }

 private:
    std::uint32_t vertex_count_ = 0;
    std::vector<Face> faces_;
    std::vector<BaseEdge> edges_;
    std::vector<std::array<std::uint32_t, 3>> face_edges_;
};

/// Number of interior grid points of a face at level j: (2^j - 1)(2^j - 2)/2.
constexpr std::uint64_t interior_points(unsigned level) {
    const std::uint64_t n = std::uint64_t{1} << level;
    return (n - 1) * (n - 2) / 2;
}
/// V(j), the number of vertices at level j.
constexpr std::uint64_t vertices_at_level(std::uint64_t V0, std::uint64_t E0, std::uint64_t F0, unsigned level) {
    return V0 + E0 * ((std::uint64_t{1} << level) - 1) + F0 * interior_points(level);
}
inline std::uint64_t vertices_at_level(const BaseMesh& base, unsigned level) {
    return vertices_at_level(base.vertex_count(), base.edge_count(), base.face_count(), level);
}

/// Place of a new interior point (i, k) of level j >= 2 within its face's run of that level; i, k >= 1, i + k < 2^j,
/// i or k odd. The run has interior_points(j) - interior_points(j-1) entries.
constexpr std::uint32_t interior_rank(unsigned level, std::uint32_t i, std::uint32_t k) {
    const std::uint32_t n = 1u << level;
    const std::uint32_t odd_rows = i / 2, even_rows = (i - 1) / 2;
    // An odd row i holds n-1-i new points, an even one (n-i)/2: sums of two arithmetic series.
    const std::uint32_t before = odd_rows * (n - 2) - odd_rows * (odd_rows - (odd_rows > 0)) + even_rows * (n / 2) -
                                 even_rows * (even_rows + 1) / 2;
    return before + (i % 2 == 1 ? k - 1 : (k - 1) / 2);
}

/// Index, in hierarchical order, of grid point (i, k) of face f at level j. O(j).
std::uint32_t vertex_index(const BaseMesh& base, std::uint32_t f, unsigned level, std::uint32_t i, std::uint32_t k);

/// Index of the point at share t/2^j of a base edge's way from v[0] to v[1], 0 <= t <= 2^j. O(j).
std::uint32_t edge_vertex_index(const BaseMesh& base, const BaseEdge& edge, unsigned level, std::uint32_t t);

/// Place of grid point (i, k) among all (n+1)(n+2)/2 of a face, rows of rising i.
constexpr std::size_t patch_place(std::uint32_t n, std::uint32_t i, std::uint32_t k) {
    return std::size_t{i} * (2 * n + 3 - i) / 2 + k;
}
/// Indices of all grid points of face f at level j, as patch_place() places them. `out` is resized.
void patch_vertices(const BaseMesh& base, std::uint32_t f, unsigned level, std::vector<std::uint32_t>& out);

/// The 4^j triangles of each base face in order, as one mesh's faces; face f's are [f 4^j, (f+1) 4^j).
std::vector<Face> triangles_at_level(const BaseMesh& base, unsigned level);

/// A semi-regular mesh with its geometry.
struct SemiRegularMesh {
    BaseMesh base;
    unsigned levels = 0;                   // L
    std::vector<Vec3> positions;           // V(L), hierarchical order
    std::vector<std::uint8_t> creases;     // empty, or 1 for each base edge along which it is sharp, or its material ends
    std::vector<std::uint32_t> materials;  // empty, or a label for each base face
    std::vector<Rgba8> colors;             // empty, or V(L)
    std::vector<VertexField> fields{};     // of V(L) vertices
};

/// Flags of the V(L) vertices on boundaries, on creases and between faces of different materials.
std::vector<std::uint8_t> line_vertices(const SemiRegularMesh& mesh);

/// Positions and triangles of the finest levels of all parts, one after the other.
Mesh finest_mesh(std::span<const SemiRegularMesh> parts);

}  // namespace mvw
