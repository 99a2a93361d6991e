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

/// Finds the place of a face's grid points in a tile's block of one level, by way of names that are alike in all faces.
class Locator {
 public:
    Locator(const BaseMesh& base, const Tiling& tiling, std::uint32_t tile, unsigned level)
        : base_(base), tiling_(tiling), tile_(tile), level_(level), n_(std::int64_t{1} << level) {
        if (level == 0) return;
        const auto edges = static_cast<std::uint32_t>(tiling.tiles[tile].edges.size());
        along_ = static_cast<std::uint32_t>(n_ / 2);
        first_interior_ = edges * along_;
        run_ = static_cast<std::uint32_t>(interior_points(level) - interior_points(level - 1));
    }

    /// Below run_, a point inside; then those along the three sides; last, one that is outside or not new at this
    /// level.
    [[nodiscard]] std::uint32_t name(GridPoint p) const {
        if (!inside(p, n_) || (p.i % 2 == 0 && p.k % 2 == 0)) return no_name();
        if (p.k == 0) return side_name(0, p.i);
        if (p.i + p.k == n_) return side_name(1, p.k);
        if (p.i == 0) return side_name(2, n_ - p.k);
        return interior_rank(level_, static_cast<std::uint32_t>(p.i), static_cast<std::uint32_t>(p.k));
    }
    /// The places of all names in a face of the tile; `none` where there is none, or it is another tile's.
    void places(std::uint32_t f, std::uint32_t none, std::vector<std::uint32_t>& out) const {
        out.resize(no_name() + 1);
        const auto sides = out.begin() + run_;
        std::iota(out.begin(), sides, first_interior_ + tiling_.face[f].slot * run_);
        for (unsigned s = 0; s < 3; ++s)
            for (std::uint32_t t = 0; t < along_; ++t) sides[s * along_ + t] = std::min(on_side(f, s, t), none);
        out.back() = none;
    }
    /// kNone where there is none, or it is another tile's.
    [[nodiscard]] std::uint32_t operator()(std::uint32_t f, GridPoint p) const {
        const std::uint32_t named = name(p);
        if (named == no_name()) return kNone;
        if (named >= run_) return on_side(f, (named - run_) / along_, (named - run_) % along_);
        const Tiling::Place at = tiling_.face[f];
        return at.tile == tile_ ? first_interior_ + at.slot * run_ + named : kNone;
    }

 private:
    [[nodiscard]] std::uint32_t no_name() const { return run_ + 3 * along_; }
    [[nodiscard]] std::uint32_t side_name(unsigned s, std::int64_t t) const {
        return run_ + s * along_ + static_cast<std::uint32_t>(t / 2);
    }
    /// t: of the new points along a side, from its first corner on.
    [[nodiscard]] std::uint32_t on_side(std::uint32_t f, unsigned s, std::uint32_t t) const {
        const Tiling::Place at = tiling_.edge[base_.edge_of(f, s)];
        if (at.tile != tile_) return kNone;
        return at.slot * along_ + (base_.runs_along(f, s) ? t : along_ - 1 - t);
    }

    const BaseMesh& base_;
    const Tiling& tiling_;
    std::uint32_t tile_;
    unsigned level_;
    std::int64_t n_;
    std::uint32_t first_interior_ = 0;
    std::uint32_t run_ = 0, along_ = 0;  // new points inside a face, along a side
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

/// Names of the neighbours of a point inside a face.
BlockShape::Neighbors neighbor_names(const Locator& here, GridPoint p) {
    const GridPoint d = edge_direction(p), twice{2 * d.i, 2 * d.k};
    const auto [a, b] = other_directions(d);
    return {here.name(p - a),     here.name(p + a),     here.name(p - b),     here.name(p + b),
            here.name(p - twice), here.name(p + twice), here.name(p - a - a), here.name(p + a + a),
            here.name(p - b - b), here.name(p + b + b)};
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

/// The ends of a new point's edge, as points of the level below.
std::array<GridPoint, 2> ends_of(GridPoint p) {
    const GridPoint d = edge_direction(p), a = p - d, b = p + d;
    return {{{a.i / 2, a.k / 2}, {b.i / 2, b.k / 2}}};
}

/// A place of its own for neighbours and parents that there are not, behind the others: readers then need not ask.
template <typename List>
List with_missing(List list, std::uint32_t none) {
    for (std::uint32_t& place : list) place = std::min(place, none);
    return list;
}

template <typename List>
std::span<std::uint32_t> numbers_from(std::vector<List>& lists, std::size_t first) {
    return {lists[first].data(), (lists.size() - first) * List().size()};
}

/// Names, written down where those of the last face will be, become places in each face.
void spread_names(const std::vector<std::uint32_t>& faces, std::uint32_t none, const Locator& locator,
                  std::span<std::uint32_t> out) {
    const std::size_t run = out.size() / faces.size();
    const std::span<std::uint32_t> names = out.last(run);
    std::vector<std::uint32_t> places;
    for (std::size_t slot = 0; slot < faces.size(); ++slot) {
        locator.places(faces[slot], none, places);
        const std::span<std::uint32_t> own = out.subspan(slot * run, run);
        for (std::size_t k = 0; k < run; ++k) own[k] = places[names[k]];
    }
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

std::vector<BlockRun> block_runs(const BaseMesh& base, const Tiling::Tile& tile, unsigned level) {
    std::vector<BlockRun> runs;
    if (level == 0) {
        for (const std::uint32_t v : tile.vertices) runs.push_back({v, 1});
        return runs;
    }
    const auto inside = static_cast<std::uint32_t>(interior_points(level) - interior_points(level - 1));
    const auto along = std::uint32_t{1} << (level - 1);
    const auto start = static_cast<std::uint32_t>(vertices_at_level(base, level - 1));
    for (const std::uint32_t e : tile.edges) runs.push_back({start + e * along, along});
    if (inside == 0) return runs;
    for (const std::uint32_t f : tile.faces) runs.push_back({start + base.edge_count() * along + f * inside, inside});
    return runs;
}

std::vector<std::uint32_t> block_indices(const BaseMesh& base, const Tiling::Tile& tile, unsigned level) {
    std::vector<std::uint32_t> indices(static_cast<std::size_t>(block_size(tile, level)));
    auto to = indices.begin();
    for (const BlockRun& run : block_runs(base, tile, level)) {
        std::iota(to, to + run.count, run.vertex);
        to += run.count;
    }
    return indices;
}

BlockShape::BlockShape(const BaseMesh& base, const Tiling& tiling, std::uint32_t tile, unsigned level) {
    const Tiling::Tile& owned = tiling.tiles[tile];
    indices_ = block_indices(base, owned, level);
    const auto none = static_cast<std::uint32_t>(size());
    neighbors_.reserve(size());
    if (level == 0) {
        for (const Neighbors& list : base_neighbors(base, tiling, tile)) neighbors_.push_back(with_missing(list, none));
        return;
    }
    if (level > 1) parents_.reserve(size());
    const auto no_parent = static_cast<std::uint32_t>(block_size(owned, level - 1));
    const Locator here(base, tiling, tile, level), coarse(base, tiling, tile, level - 1);
    const auto n = std::int64_t{1} << level;
    for (const std::uint32_t e : owned.edges) {
        const BaseEdge& edge = base.edges()[e];
        for (std::int64_t t = 1; t < n; t += 2) {
            neighbors_.push_back(with_missing(edge_neighbors(here, edge, n, t), none));
            if (level == 1) continue;
            const auto [a, b] = ends_of(side_point(edge.side[0], n, t));
            parents_.push_back(with_missing(Parents{coarse(edge.face[0], a), coarse(edge.face[0], b)}, no_parent));
        }
    }
    const std::size_t first = neighbors_.size();
    if (first == size()) return;  // nothing is inside faces
    neighbors_.resize(size());
    parents_.resize(size());
    std::size_t at = size() - (size() - first) / owned.faces.size();  // the last face's
    for (std::int64_t i = 1; i < n; ++i)
        for (std::int64_t k = 1, step = i % 2 == 1 ? 1 : 2; i + k < n; k += step, ++at) {
            const auto [a, b] = ends_of({i, k});
            neighbors_[at] = neighbor_names(here, {i, k});
            parents_[at] = {coarse.name(a), coarse.name(b)};
        }
    spread_names(owned.faces, none, here, numbers_from(neighbors_, first));
    spread_names(owned.faces, no_parent, coarse, numbers_from(parents_, first));
}

}  // namespace mvw
