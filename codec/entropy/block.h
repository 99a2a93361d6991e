// A block: the quantised coefficients of one (part, tile, level, channel), the unit that is coded on its own. This file
// names its coefficients, their order and who is whose neighbour: what encoder and decoder must agree on (FORMAT.md 6).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Which base vertices, edges and faces each tile owns. A face is its tile's; an edge or vertex belongs to the tile of
/// its first (lowest-numbered) face. A vertex without faces belongs to tile 0.
struct Tiling {
    struct Tile {
        std::vector<std::uint32_t> vertices, edges, faces;  // rising
    };
    std::vector<Tile> tiles;
    /// For each base vertex, edge, face: its tile, and its place in that tile's list.
    struct Place {
        std::uint32_t tile, slot;
    };
    std::vector<Place> vertex, edge, face;

    Tiling() = default;
    /// tile_of_face: F labels below tile_count. O(V + E + F).
    Tiling(const BaseMesh& base, std::span<const std::uint16_t> tile_of_face, std::uint32_t tile_count);
};

/// Number of coefficients of a tile's block of a level: V(level) - V(level-1) restricted to what the tile owns.
std::uint64_t block_size(const Tiling::Tile& tile, unsigned level);

/// Coefficients that follow one another in coding order (BlockShape) and whose vertices do so in hierarchical order: from
/// level 1 on, those of one base edge or inside one base face.
struct BlockRun {
    std::uint32_t vertex, count;  // the first one, and how many: at least one
};
/// All of a tile's block of a level, in coding order.
std::vector<BlockRun> block_runs(const BaseMesh& base, const Tiling::Tile& tile, unsigned level);

/// Each coefficient's vertex in hierarchical order, in coding order.
std::vector<std::uint32_t> block_indices(const BaseMesh& base, const Tiling::Tile& tile, unsigned level);

/// The coefficients of a block in coding order, and the relations from which contexts are formed.
///
/// Order: level 0, the tile's base vertices; level j >= 1, for each of the tile's base edges its 2^(j-1) new points
/// along the edge's direction, then for each of its faces the new interior points as semi_regular.h ranks them.
///
/// Neighbours of a coefficient, all of the same block (size() where there is none: outside the tile or the surface, or
/// across a base edge from a face's inside): level 0, up to ten base vertices joined by an edge. Level j >= 1: four on
/// the other sides of the two triangles at the point's edge, two that follow on the line of the edge, four more of the
/// same direction. Parents: ends of the point's edge that were new at level j-1, as places in that level's block of the
/// tile; that block's size where there is none.
class BlockShape {
 public:
    static constexpr unsigned kNeighbors = 10;
    static constexpr unsigned kParents = 2;
    using Neighbors = std::array<std::uint32_t, kNeighbors>;
    using Parents = std::array<std::uint32_t, kParents>;

    /// Linear in the block's size; make it once for a tile and level.
    BlockShape(const BaseMesh& base, const Tiling& tiling, std::uint32_t tile, unsigned level);

    [[nodiscard]] std::size_t size() const { return indices_.size(); }
    /// Each coefficient's vertex in hierarchical order.
    [[nodiscard]] std::span<const std::uint32_t> indices() const { return indices_; }
    [[nodiscard]] std::span<const Neighbors> neighbors() const { return neighbors_; }
    /// Empty at levels 0 and 1: the coefficients of level 0 are rounding, which predicts nothing.
    [[nodiscard]] std::span<const Parents> parents() const { return parents_; }

 private:
    std::vector<std::uint32_t> indices_;
    std::vector<Neighbors> neighbors_;
    std::vector<Parents> parents_;
};

}  // namespace mvw
