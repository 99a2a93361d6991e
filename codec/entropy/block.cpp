#include "codec/entropy/block.h"

#include <algorithm>
#include <numeric>

namespace mvw {

namespace {

struct GridPoint {
    std::int64_t i, k;
    friend GridPoint operator+(GridPoint a, GridPoint b) { return {a.i + b.i, a.k + b.k}; }
    friend GridPoint operator-(GridPoint a, GridPoint b) { return {a.i - b.i, a.k - b.k}; }
};

/// Direction of the level-(j-1) edge whose middle a new point is.
GridPoint edge_direction(GridPoint p) {
    if (p.k % 2 == 0) return {1, 0};
    if (p.i % 2 == 0) return {0, 1};
    return {1, -1};
}

/// The two grid directions besides d.
std::array<GridPoint, 2> other_directions(GridPoint d) {
    if (d.k == 0) return {{{0, 1}, {1, -1}}};
    if (d.i == 0) return {{{1, 0}, {1, -1}}};
    return {{{1, 0}, {0, 1}}};
}

bool inside(GridPoint p, std::int64_t n) {
    return p.i >= 0 && p.k >= 0 && p.i + p.k <= n;
}

/// Grid point at parameter t along side s of a face (semi_regular.h).
GridPoint side_point(unsigned s, std::int64_t n, std::int64_t t) {
    if (s == 0) return {t, 0};
    if (s == 1) return {n - t, t};
    return {0, n - t};
}

/// Finds the place of a face's grid points in a tile's block of one level.
class Locator {
 public:
    Locator(const BaseMesh& base, const Tiling& tiling, std::uint32_t tile, unsigned level)
        : base_(base), tiling_(tiling), tile_(tile), level_(level), n_(std::int64_t{1} << level) {
        if (level == 0) return;
        const auto edges = static_cast<std::uint32_t>(tiling.tiles[tile].edges.size());
        first_interior_ = edges * static_cast<std::uint32_t>(n_ / 2);
        run_ = static_cast<std::uint32_t>(interior_points(level) - interior_points(level - 1));
    }

    /// kNone for a point that is outside the face, not new at this level, or another tile's.
    [[nodiscard]] std::uint32_t operator()(std::uint32_t f, GridPoint p) const {
        if (!inside(p, n_) || (p.i % 2 == 0 && p.k % 2 == 0)) return kNone;
        if (p.k == 0) return on_side(f, 0, p.i);
        if (p.i + p.k == n_) return on_side(f, 1, p.k);
        if (p.i == 0) return on_side(f, 2, n_ - p.k);
        const Tiling::Place place = tiling_.face[f];
        if (place.tile != tile_) return kNone;
        return first_interior_ + place.slot * run_ +
               interior_rank(level_, static_cast<std::uint32_t>(p.i), static_cast<std::uint32_t>(p.k));
    }
    [[nodiscard]] std::uint32_t run() const { return run_; }

 private:
    [[nodiscard]] std::uint32_t on_side(std::uint32_t f, unsigned s, std::int64_t t) const {
        const Tiling::Place place = tiling_.edge[base_.edge_of(f, s)];
        if (place.tile != tile_) return kNone;
        const std::int64_t along = base_.runs_along(f, s) ? t : n_ - t;
        return static_cast<std::uint32_t>(place.slot * (n_ / 2) + along / 2);
    }

    const BaseMesh& base_;
    const Tiling& tiling_;
    std::uint32_t tile_;
    unsigned level_;
    std::int64_t n_;
    std::uint32_t first_interior_ = 0, run_ = 0;
};

void add_unless_full(BlockShape::Neighbors& list, std::uint32_t place) {
    if (const auto free = std::find(list.begin(), list.end(), kNone); free != list.end()) *free = place;
}

std::vector<BlockShape::Neighbors> base_neighbors(const BaseMesh& base, const Tiling& tiling, std::uint32_t tile) {
    BlockShape::Neighbors none;
    none.fill(kNone);
    std::vector<BlockShape::Neighbors> neighbors(tiling.tiles[tile].vertices.size(), none);
    for (const BaseEdge& e : base.edges()) {
        const Tiling::Place a = tiling.vertex[e.v[0]], b = tiling.vertex[e.v[1]];
        if (a.tile != tile || b.tile != tile) continue;
        add_unless_full(neighbors[a.slot], b.slot);
        add_unless_full(neighbors[b.slot], a.slot);
    }
    return neighbors;
}

BlockShape::Neighbors interior_neighbors(const Locator& place, std::uint32_t f, GridPoint p) {
    const GridPoint d = edge_direction(p), twice{2 * d.i, 2 * d.k};
    const auto [a, b] = other_directions(d);
    return {place(f, p - a),     place(f, p + a),     place(f, p - b),     place(f, p + b),     place(f, p - twice),
            place(f, p + twice), place(f, p - a - a), place(f, p + a + a), place(f, p - b - b), place(f, p + b + b)};
}

/// Neighbours of point t of a base edge: those inside each of its faces, and those along it.
BlockShape::Neighbors edge_neighbors(const Locator& place, const BaseEdge& e, std::int64_t n, std::int64_t t) {
    BlockShape::Neighbors list;
    list.fill(kNone);
    std::size_t near = 0, far = 6;
    for (unsigned side = 0; side < 2 && e.face[side] != kNone; ++side) {
        const GridPoint p = side_point(e.side[side], n, side == 0 ? t : n - t);
        for (const GridPoint d : other_directions(edge_direction(p)))
            for (const GridPoint q : {GridPoint{-d.i, -d.k}, d}) {
                if (!inside(p + q, n)) continue;
                list[near++] = place(e.face[side], p + q);
                list[far++] = place(e.face[side], p + q + q);
            }
    }
    list[4] = place(e.face[0], side_point(e.side[0], n, t - 2));
    list[5] = place(e.face[0], side_point(e.side[0], n, t + 2));
    return list;
}

/// Whether all that a point's lists can name is strictly inside its face: then every face's lists are alike.
bool deep_inside(GridPoint p, std::int64_t n) {
    return p.i > 2 && p.k > 2 && p.i + p.k < n - 2;
}

template <typename List>
List shifted(List list, std::uint32_t by) {
    for (std::uint32_t& place : list)
        if (place != kNone) place += by;
    return list;
}

BlockShape::Parents parents_of(const Locator& coarse, std::uint32_t f, GridPoint p) {
    const GridPoint d = edge_direction(p), a = p - d, b = p + d;
    return {coarse(f, {a.i / 2, a.k / 2}), coarse(f, {b.i / 2, b.k / 2})};
}

}  // namespace

Tiling::Tiling(const BaseMesh& base, std::span<const std::uint16_t> tile_of_face, std::uint32_t tile_count)
    : tiles(tile_count), vertex(base.vertex_count(), Place{kNone, 0}) {
    const auto claim = [this](std::uint32_t tile, std::vector<std::uint32_t> Tile::*list, std::uint32_t member) {
        std::vector<std::uint32_t>& members = tiles[tile].*list;
        members.push_back(member);
        return Place{tile, static_cast<std::uint32_t>(members.size() - 1)};
    };
    std::vector<std::uint32_t> tile_of_vertex(base.vertex_count(), kNone);
    face.reserve(base.face_count());
    for (std::uint32_t f = 0; f < base.face_count(); ++f) {
        face.push_back(claim(tile_of_face[f], &Tile::faces, f));
        for (const std::uint32_t v : base.faces()[f])
            if (tile_of_vertex[v] == kNone) tile_of_vertex[v] = tile_of_face[f];
    }
    edge.reserve(base.edge_count());
    for (std::uint32_t e = 0; e < base.edge_count(); ++e)
        edge.push_back(claim(tile_of_face[base.edges()[e].face[0]], &Tile::edges, e));
    for (std::uint32_t v = 0; v < base.vertex_count(); ++v)
        vertex[v] = claim(tile_of_vertex[v] == kNone ? 0 : tile_of_vertex[v], &Tile::vertices, v);
}

std::uint64_t block_size(const Tiling::Tile& tile, unsigned level) {
    if (level == 0) return tile.vertices.size();
    return tile.edges.size() * (std::uint64_t{1} << (level - 1)) +
           tile.faces.size() * (interior_points(level) - interior_points(level - 1));
}

std::vector<std::uint32_t> block_indices(const BaseMesh& base, const Tiling::Tile& tile, unsigned level) {
    if (level == 0) return tile.vertices;
    std::vector<std::uint32_t> indices(static_cast<std::size_t>(block_size(tile, level)));
    const auto run = static_cast<std::uint32_t>(interior_points(level) - interior_points(level - 1));
    const auto along = std::uint32_t{1} << (level - 1);
    const auto start = static_cast<std::uint32_t>(vertices_at_level(base, level - 1));
    auto to = indices.begin();
    const auto add = [&to](std::uint32_t first, std::uint32_t count) {
        std::iota(to, to + count, first);
        to += count;
    };
    for (const std::uint32_t e : tile.edges) add(start + e * along, along);
    for (const std::uint32_t f : tile.faces) add(start + base.edge_count() * along + f * run, run);
    return indices;
}

BlockShape::BlockShape(const BaseMesh& base, const Tiling& tiling, std::uint32_t tile, unsigned level) {
    const Tiling::Tile& owned = tiling.tiles[tile];
    indices_ = block_indices(base, owned, level);
    if (level == 0) {
        neighbors_ = base_neighbors(base, tiling, tile);
        name_what_is_missing(0);
        return;
    }
    const auto n = std::int64_t{1} << level;
    const Locator place(base, tiling, tile, level), coarse(base, tiling, tile, level - 1);
    neighbors_.reserve(size());
    if (level > 1) parents_.reserve(size());
    const auto add = [this, level](const Neighbors& neighbors, const Locator& below, std::uint32_t f, GridPoint p) {
        neighbors_.push_back(neighbors);
        if (level > 1) parents_.push_back(parents_of(below, f, p));
    };
    for (const std::uint32_t e : owned.edges) {
        const BaseEdge& edge = base.edges()[e];
        for (std::int64_t t = 1; t < n; t += 2)
            add(edge_neighbors(place, edge, n, t), coarse, edge.face[0], side_point(edge.side[0], n, t));
    }
    const std::size_t pattern = neighbors_.size();  // the first face's run, which the others repeat
    for (std::uint32_t slot = 0; slot < owned.faces.size(); ++slot) {
        const std::uint32_t f = owned.faces[slot];
        std::size_t rank = 0;
        for (std::int64_t i = 1; i < n; ++i)
            for (std::int64_t k = 1, step = i % 2 == 1 ? 1 : 2; i + k < n; k += step, ++rank) {
                if (slot == 0 || !deep_inside({i, k}, n)) {
                    add(interior_neighbors(place, f, {i, k}), coarse, f, {i, k});
                    continue;
                }
                neighbors_.push_back(shifted(neighbors_[pattern + rank], slot * place.run()));
                parents_.push_back(shifted(parents_[pattern + rank], slot * coarse.run()));
            }
    }
    name_what_is_missing(block_size(owned, level - 1));
}

/// A place of its own for neighbours and parents that there are not, behind the others: readers then need not ask.
void BlockShape::name_what_is_missing(std::uint64_t coarse_size) {
    const auto none = static_cast<std::uint32_t>(size()), no_parent = static_cast<std::uint32_t>(coarse_size);
    for (Neighbors& list : neighbors_)
        for (std::uint32_t& place : list) place = std::min(place, none);
    for (Parents& list : parents_)
        for (std::uint32_t& place : list) place = std::min(place, no_parent);
}

}  // namespace mvw
