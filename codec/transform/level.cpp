#include "codec/transform/level.h"

#include <algorithm>

namespace mvw {

namespace {

struct GridPoint {
    std::uint32_t i, k;
};

/// Side of the face that both grid points lie on, or 3.
unsigned common_side(GridPoint a, GridPoint b, std::uint32_t n) {
    if (a.k == 0 && b.k == 0) return 0;
    if (a.i + a.k == n && b.i + b.k == n) return 1;
    if (a.i == 0 && b.i == 0) return 2;
    return 3;
}

void add_faces(Level& level, const BaseMesh& base, unsigned j, std::span<const std::uint8_t> creases) {
    const std::uint32_t n = 1u << j;
    std::vector<std::uint32_t> patch, finer;
    for (std::uint32_t f = 0; f < base.face_count(); ++f) {
        patch_vertices(base, f, j, patch);
        patch_vertices(base, f, j + 1, finer);
        const auto name = [&](GridPoint p) { return patch[patch_place(n, p.i, p.k)]; };
        for (std::uint32_t i = 0; i < n; ++i)
            for (std::uint32_t k = 0; i + k < n; ++k) {
                const std::array<GridPoint, 3> corner{{{i, k}, {i + 1, k}, {i, k + 1}}};
                const auto half = static_cast<std::uint32_t>(3 * level.faces.size());
                level.faces.push_back({name(corner[0]), name(corner[1]), name(corner[2])});
                for (unsigned s = 0; s < 3; ++s) {
                    const GridPoint a = corner[s], b = corner[(s + 1) % 3];
                    const unsigned side = common_side(a, b, n);
                    if (side < 3 && !base.runs_along(f, side)) continue;
                    const bool sharp = side < 3 && (base.edges()[base.edge_of(f, side)].face[1] == kNone ||
                                                    (!creases.empty() && creases[base.edge_of(f, side)] != 0));
                    level.edges.push_back({half + s, finer[patch_place(2 * n, a.i + b.i, a.k + b.k)], sharp});
                }
                if (i + k + 2 <= n) level.faces.push_back({name({i + 1, k}), name({i + 1, k + 1}), name({i, k + 1})});
            }
    }
}

/// Half-edges by the vertex they start at, then by the one they end at.
class Starts {
 public:
    explicit Starts(const Level& level)
        : level_(level), first_(level.vertex_count + 1), halves_(3 * level.faces.size()) {
        for (const Face& f : level.faces)
            for (const std::uint32_t v : f) ++first_[v + 1];
        for (std::uint32_t v = 0; v < level.vertex_count; ++v) first_[v + 1] += first_[v];
        std::vector<std::uint32_t> by_end(halves_.size()), place(level.vertex_count + 1);
        for (std::uint32_t h = 0; h < halves_.size(); ++h) ++place[level.to(h) + 1];
        for (std::uint32_t v = 0; v < level.vertex_count; ++v) place[v + 1] += place[v];
        for (std::uint32_t h = 0; h < halves_.size(); ++h) by_end[place[level.to(h)]++] = h;
        place.assign(first_.begin(), first_.end());
        for (const std::uint32_t h : by_end) halves_[place[level.from(h)]++] = h;
    }
    /// The half-edge from a to b, kNone where there is none.
    [[nodiscard]] std::uint32_t find(std::uint32_t a, std::uint32_t b) const {
        const auto end = halves_.begin() + first_[a + 1];
        const auto found = std::lower_bound(halves_.begin() + first_[a], end, b,
                                            [&](std::uint32_t h, std::uint32_t v) { return level_.to(h) < v; });
        return found != end && level_.to(*found) == b ? *found : kNone;
    }

 private:
    const Level& level_;
    std::vector<std::uint32_t> first_, halves_;
};

void join_half_edges(Level& level) {
    const auto halves = static_cast<std::uint32_t>(3 * level.faces.size());
    const Starts starts(level);
    level.twin.assign(halves, kNone);
    for (std::uint32_t h = 0; h < halves; ++h) level.twin[h] = starts.find(level.to(h), level.from(h));
    level.edge_of.assign(halves, kNone);
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        const std::uint32_t h = level.edges[e].half;
        level.edge_of[h] = e;
        if (level.twin[h] != kNone) level.edge_of[level.twin[h]] = e;
    }
}

void list_vertex_edges(Level& level) {
    const std::uint32_t V = level.vertex_count;
    level.valence.assign(V, 0);
    level.sharp_edges.assign(V, 0);
    for (const Level::Edge& e : level.edges)
        for (const std::uint32_t v : {level.from(e.half), level.to(e.half)}) {
            ++level.valence[v];
            level.sharp_edges[v] += e.sharp ? 1 : 0;
        }
    level.first_edge.assign(V + 1, 0);
    for (std::uint32_t v = 0; v < V; ++v) level.first_edge[v + 1] = level.first_edge[v] + level.valence[v];
    level.vertex_edges.resize(2 * level.edges.size());
    std::vector<std::uint32_t> place(level.first_edge.begin(), level.first_edge.end() - 1);
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        level.vertex_edges[place[level.from(level.edges[e].half)]++] = e;
        level.vertex_edges[place[level.to(level.edges[e].half)]++] = e;
    }
}

}  // namespace

std::array<std::uint32_t, 2> Level::curve_neighbours(std::uint32_t v) const {
    std::array<std::uint32_t, 2> ends{kNone, kNone};
    unsigned count = 0;
    for (const std::uint32_t e : edges_at(v))
        if (edges[e].sharp) ends[count++] = other_end(e, v);
    return ends;
}

TenPoints Level::ten_points(std::uint32_t edge) const {
    const std::uint32_t h = edges[edge].half, back = twin[h];
    const auto across = [&](std::uint32_t g) { return edges[edge_of[g]].sharp ? kNone : tip(twin[g]); };
    TenPoints p;
    p.ends = {from(h), to(h)};
    p.opp = {tip(h), back == kNone ? kNone : tip(back)};
    p.wings = {across(prev(h)), across(next(h)), back == kNone ? kNone : across(next(back)),
               back == kNone ? kNone : across(prev(back))};
    // Three turns around a regular end lead to the edge that continues this one.
    const auto beyond = [&](std::uint32_t g) {
        for (unsigned turn = 0; turn < 3; ++turn) g = twin[prev(g)];
        return to(g);
    };
    p.far = {regular(p.ends[0]) ? beyond(h) : kNone, regular(p.ends[1]) ? beyond(back) : kNone};
    return p;
}

Level make_level(const BaseMesh& base, unsigned level, std::span<const std::uint8_t> creases) {
    Level result;
    result.vertex_count = static_cast<std::uint32_t>(vertices_at_level(base, level));
    result.faces.reserve(std::size_t{base.face_count()} << (2 * level));
    add_faces(result, base, level, creases);
    join_half_edges(result);
    list_vertex_edges(result);
    return result;
}

}  // namespace mvw
