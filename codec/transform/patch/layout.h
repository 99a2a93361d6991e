// Where the points of one patch lie in memory, and how points outside it are found in its neighbours.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/mesh/semi_regular.h"

namespace mvw {

/// One triangular plane of floats for a base face at a level of n = 2^j: rows i = -2 ... n+1, row i holds
/// k = -2 ... n+1-i. The vertices are 0 <= i, k and i + k <= n; all else is ghost border: copies from the neighbours.
///
/// Three planes hold a vector for each vertex. Details live on the edges of this level in planes of the same layout:
/// H(i,k) from (i,k) to (i+1,k), V(i,k) from (i,k) to (i,k+1), D(i,k) from (i+1,k) to (i,k+1).
struct Layout {
    int n = 0;
    std::uint32_t plane = 0;  // floats in one plane

    explicit Layout(unsigned level) : n(1 << level) {
        for (int i = -2, at = 2; i <= n + 2; at += n + 4 - i, ++i) row_starts_.push_back(at);
        // Vectors may run over the last row by less than sixteen: never into another patch, which another thread may
        // be writing.
        plane = static_cast<std::uint32_t>(row_starts_.back() + 16 + 7) / 8 * 8;
    }
    /// Offset of (i, 0).
    [[nodiscard]] std::ptrdiff_t row(int i) const { return row_starts_[static_cast<std::size_t>(i + 2)]; }
    [[nodiscard]] std::uint32_t at(int i, int k) const { return static_cast<std::uint32_t>(row(i) + k); }

 private:
    std::vector<std::int32_t> row_starts_;
};

/// Floats that kernels may read or write past the last plane.
inline constexpr std::size_t kPlanePadding = 64;

/// Vertex or edge of the grid of one base face; i and k may leave the triangle by a little.
struct GridVertex {
    std::uint32_t face;
    int i, k;
};
enum EdgePlane : std::uint8_t { kH = 0, kV = 1, kD = 2 };
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
