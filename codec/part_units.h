// In which units the symbols of a part's geometry are, and along which axes those of level 0 lie (FORMAT.md 4.3).
// Shared by both directions.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/semi_regular.h"
#include "codec/part_params.h"
#include "codec/transform/frames.h"

namespace mvw {

/// Where within a smooth surface a vertex lies matters little, so tangents have coarser steps. On a line (a boundary, a
/// crease, a border between materials) both directions across it matter: there only the one along it is coarse, and at
/// base vertices on lines none is.
class PartUnits {
 public:
    using Grid = std::vector<GridPoint>;

    PartUnits() = default;
    /// creases, materials: as in SemiRegularMesh. grid: positions of the base on params.lattice.
    PartUnits(const BaseMesh& base, std::span<const std::uint8_t> creases, std::span<const std::uint32_t> materials,
              const Grid& grid, const PartParams& params);

    /// Steps of plane 0 of a coefficient's components. vertex: its index in hierarchical order, of that level.
    [[nodiscard]] Vec3f steps(unsigned level, std::uint32_t vertex) const;
    /// Axes of a base vertex' coefficient: of the normal of the base as the grid has it, or the model's.
    [[nodiscard]] const Frame<float>& frame(std::uint32_t vertex) const { return frames_[vertex]; }
    /// A base vertex' position on the grid.
    [[nodiscard]] const Vec3f& origin(std::uint32_t vertex) const { return origins_[vertex]; }

 private:
    std::vector<Vec3f> smooth_, line_;               // steps by level: within the surface, on lines
    std::vector<std::uint64_t> first_;               // of each level >= 1: its first new vertex
    std::vector<std::uint8_t> on_line_, line_edge_;  // of base vertices and edges
    std::vector<Frame<float>> frames_;
    std::vector<Vec3f> origins_;
};

}  // namespace mvw
