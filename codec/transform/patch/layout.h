// Where the points of one patch lie in memory, and how points outside it are found in its neighbours.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/mesh/semi_regular.h"

namespace mvw {

enum EdgePlane : std::uint8_t { kH = 0, kV = 1, kD = 2 };

/// Patches lie side by side in the lanes of vectors: a group of `lanes` patches (16, 8, 4 or 1) holds each of its grid
/// points once for all of them, x of every lane, then y, then z. So all patches of a group share every offset, whatever
/// their size, vectors are full on the coarsest level too, and no lane ever needs its neighbour's.
///
/// Vertices of a level of n = 2^j segments: 0 <= i, k and i + k <= n, and one row of ghosts beyond each side (the
/// neighbour's first inner row), n of them. Details live on the edges of this level: H(i,k) from (i,k) to (i+1,k),
/// V(i,k) from (i,k) to (i,k+1), D(i,k) from (i+1,k) to (i,k+1), those inside the triangle and on its sides, in the
/// order of the finer level's rows: V of row i, then H and D of row i in turn. No detail has a ghost.
///
/// All offsets are in floats, of the first lane's x.
struct Layout {
    int n = 0;
    unsigned lanes = 0;
    std::uint32_t vertex_floats = 0, edge_floats = 0;  // of one group

    Layout(unsigned level, unsigned lane_count);
    /// Offset of vertex (i, k). Row starts may be asked for beyond the triangle (-1 <= i <= n + 1); what lies there is
    /// some other vertex.
    [[nodiscard]] std::ptrdiff_t row(int i) const { return row_starts_[static_cast<std::uint32_t>(i + 1)]; }
    [[nodiscard]] std::uint32_t at(int i, int k) const {
        return static_cast<std::uint32_t>(row(i) + k * static_cast<int>(stride()));
    }
    /// Offset of a detail.
    [[nodiscard]] std::uint32_t edge(EdgePlane plane, int i, int k) const {
        const int before = 3 * (i * n - i * (i - 1) / 2);
        const int in_row = plane == kV ? k : n - i + 2 * k + (plane == kD ? 1 : 0);
        return static_cast<std::uint32_t>(before + in_row) * stride();
    }
    /// The t-th vertex of side s, and the detail between the t-th and the next.
    [[nodiscard]] std::uint32_t side_vertex(unsigned s, int t) const {
        return s == 0 ? at(t, 0) : s == 1 ? at(n - t, t) : at(0, n - t);
    }
    [[nodiscard]] std::uint32_t side_edge(unsigned s, int t) const {
        return s == 0 ? edge(kH, t, 0) : s == 1 ? edge(kD, n - 1 - t, t) : edge(kV, 0, n - 1 - t);
    }
    /// Floats from a point to the next.
    [[nodiscard]] unsigned stride() const { return 3 * lanes; }

 private:
    std::vector<std::int32_t> row_starts_;
};

/// Vertex or edge of the grid of one base face; i and k may leave the triangle by a little.
struct GridVertex {
    std::uint32_t face;
    int i, k;
};
struct GridEdge {
    std::uint32_t face;
    EdgePlane plane;
    int i, k;
};

/// The base mesh as the grid sees it: who owns what, and what lies across a side. A side's points belong to the edge's
/// first face, a corner to the first face that has it.
class GridTopology {
 public:
    explicit GridTopology(const BaseMesh& base);

    [[nodiscard]] const BaseMesh& base() const { return base_; }
    [[nodiscard]] bool owns_side(std::uint32_t f, unsigned s) const { return base_.runs_along(f, s); }
    /// Face across side s, kNone on a boundary, and the side it has there.
    [[nodiscard]] std::uint32_t neighbour(std::uint32_t f, unsigned s) const;
    [[nodiscard]] unsigned neighbour_side(std::uint32_t f, unsigned s) const;
    /// Face and corner that own a base vertex.
    [[nodiscard]] std::pair<std::uint32_t, unsigned> corner_owner(std::uint32_t v) const { return corner_owner_[v]; }
    [[nodiscard]] GridVertex corner(std::uint32_t f, unsigned corner, int n) const;

    /// The owner's name of a vertex, which may lie across sides; face is kNone where the surface ends before.
    [[nodiscard]] GridVertex owner(GridVertex v, int n) const;
    [[nodiscard]] GridEdge owner(GridEdge e, int n) const;

 private:
    BaseMesh base_;
    std::vector<std::pair<std::uint32_t, unsigned>> corner_owner_;
};

/// Barycentric coordinates over the face's corners, sum n.
using Barycentric = std::array<int, 3>;
constexpr Barycentric barycentric(int i, int k, int n) {
    return {n - i - k, i, k};
}
/// The same point in the neighbour's coordinates, unfolded over side s of ours and side t of the neighbour's.
constexpr Barycentric across(const Barycentric& b, unsigned s, unsigned t) {
    const int x = b[s], y = b[(s + 1) % 3], z = b[(s + 2) % 3];
    Barycentric r{};
    r[(t + 1) % 3] = x + z;
    r[t] = y + z;
    r[(t + 2) % 3] = -z;
    return r;
}
std::array<Barycentric, 2> edge_ends(EdgePlane plane, int i, int k, int n);
/// The edge between two neighbouring points.
GridEdge edge_between(std::uint32_t face, const Barycentric& a, const Barycentric& b);

}  // namespace mvw
