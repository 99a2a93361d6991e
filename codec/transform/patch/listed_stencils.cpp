#include "codec/transform/patch/listed_stencils.h"

#include <algorithm>

namespace mvw {

namespace {

/// Grid names of a level's vertices and edges, in make_level()'s order.
struct Names {
    std::vector<GridVertex> vertices;
    std::vector<GridEdge> edges;
};

Names grid_names(const BaseMesh& base, const Level& level, int n) {
    Names names;
    names.vertices.assign(level.vertex_count, {kNone, 0, 0});
    names.edges.resize(level.edges.size());
    std::size_t t = 0;
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        for (int i = 0; i < n; ++i)
            for (int k = 0; i + k < n; ++k) {
                const std::array<GridVertex, 3> corner{{{f, i, k}, {f, i + 1, k}, {f, i, k + 1}}};
                const std::array<GridEdge, 3> edge{{{f, kH, i, k}, {f, kD, i, k}, {f, kV, i, k}}};
                for (unsigned s = 0; s < 3; ++s) {
                    if (GridVertex& v = names.vertices[level.faces[t][s]]; v.face == kNone) v = corner[s];
                    const auto half = static_cast<std::uint32_t>(3 * t + s);
                    if (const std::uint32_t e = level.edge_of[half]; level.edges[e].half == half)
                        names.edges[e] = edge[s];
                }
                t += i + k + 2 <= n ? 2 : 1;
            }
    return names;
}

struct Tools {
    const Level& level;
    const Names& names;
    const DiscreteLifting& lifting;
    const TransformOptions& options;
    TenWeights ordinary;
};

std::array<double, 10> ten_values(const TenWeights& w) {
    return {w.ends, w.ends, w.opp, w.opp, w.wings, w.wings, w.wings, w.wings, w.far, w.far};
}
std::array<std::uint32_t, 10> ten_vertices(const TenPoints& p) {
    return {p.ends[0],  p.ends[1],  p.opp[0],   p.opp[1], p.wings[0],
            p.wings[1], p.wings[2], p.wings[3], p.far[0], p.far[1]};
}

ListedStencil stencil_of(const Tools& tools, std::uint32_t e) {
    const Level::Edge& edge = tools.level.edges[e];
    const auto name = [&](std::uint32_t v) { return tools.names.vertices[v]; };
    ListedStencil result{
        tools.names.edges[e], {name(tools.level.from(edge.half)), name(tools.level.to(edge.half))}, edge.sharp, {}, {}};
    std::vector<Term> terms;
    predict_terms(tools.level, e, predict_rule(tools.options.kind), tools.options.s, terms);
    for (const Term& t : terms) result.terms.push_back({name(t.vertex), t.position, t.shape});
    if (tools.options.kind == TransformKind::Vector && is_ordinary(tools.level, e)) {
        const auto vertices = ten_vertices(tools.level.ten_points(e));
        const auto values = ten_values(kVectorShape);
        for (std::size_t i = 0; i < 10; ++i) result.terms.push_back({name(vertices[i]), 0, values[i]});
    }
    if (is_lazy(tools.options.kind)) return result;
    if (is_ordinary(tools.level, e)) {
        const auto vertices = ten_vertices(tools.level.ten_points(e));
        const auto values = ten_values(tools.ordinary);
        for (std::size_t i = 0; i < 10; ++i) result.lifts.push_back({name(vertices[i]), values[i]});
        return result;
    }
    std::vector<LiftTerm> lifts;
    tools.lifting.weights(e, tools.options.kind == TransformKind::Loop && tools.options.loop_template == 4, lifts);
    for (const LiftTerm& t : lifts) result.lifts.push_back({name(t.vertex), t.weight});
    return result;
}

/// The base vertex that an edge lies nearest to.
std::uint32_t nearest_corner(const BaseMesh& base, const GridEdge& e, int m) {
    const auto ends = edge_ends(e.plane, e.i, e.k, m);
    unsigned nearest = 0;
    const auto depth = [&](unsigned c) { return std::min(ends[0][c], ends[1][c]); };
    for (unsigned c = 1; c < 3; ++c)
        if (depth(c) > depth(nearest)) nearest = c;
    return base.faces()[e.face][nearest];
}

template <typename Place>
GridEdge moved(const GridEdge& e, int m, int n, Place place) {
    const auto ends = edge_ends(e.plane, e.i, e.k, m);
    const GridVertex a = place(e.face, ends[0]), b = place(e.face, ends[1]);
    return edge_between(a.face, barycentric(a.i, a.k, n), barycentric(b.i, b.k, n));
}

/// The stencil with each of its points moved by `place`, from a level of m to one of n points a side.
template <typename Place>
ListedStencil moved(const ListedStencil& s, int m, int n, Place place) {
    const auto vertex = [&](const GridVertex& v) { return place(v.face, barycentric(v.i, v.k, m)); };
    ListedStencil result = s;
    result.edge = moved(s.edge, m, n, place);
    for (GridVertex& v : result.ends) v = vertex(v);
    for (auto& term : result.terms) term.vertex = vertex(term.vertex);
    for (auto& lift : result.lifts) lift.vertex = vertex(lift.vertex);
    return result;
}

// A side whose middle shows what all middles look like: side 0 of face 0, a boundary or a crease.
constexpr unsigned kMiddleLevel = 4;
constexpr int kMiddle = 7;  // of 16

BaseMesh middle_base(bool crease) {
    std::vector<Face> faces{{0, 1, 2}};
    if (crease) faces.push_back({1, 0, 3});
    return BaseMesh::create(crease ? 4 : 3, std::move(faces)).value();
}

/// The edges at kMiddle along side 0 of face 0 and from it into that face: along, up, slanted back.
std::vector<ListedStencil> middle_stencils(bool crease, const TransformOptions& options) {
    const BaseMesh base = middle_base(crease);
    std::vector<std::uint8_t> creases(base.edge_count());
    creases[0] = crease ? 1 : 0;
    const ListedStencils all = explicit_stencils(base, kMiddleLevel, options, creases);
    std::vector<ListedStencil> result;
    for (const ListedStencil& s : all.edges)
        if (s.edge.face == 0 && s.edge.i == kMiddle && s.edge.k == 0) result.push_back(s);
    return result;
}

/// A fan around base vertex 0: closed, or open with one spoke more than faces.
BaseMesh fan_base(std::uint32_t faces, bool closed) {
    std::vector<Face> list;
    for (std::uint32_t i = 0; i < faces; ++i) list.push_back({0, 1 + i, 1 + (closed ? (i + 1) % faces : i + 1)});
    return BaseMesh::create(faces + (closed ? 1 : 2), std::move(list)).value();
}

/// What lies nearer to the middle of the fan than to its rim.
ListedStencils fan_stencils(const std::vector<std::uint8_t>& signature, const TransformOptions& options) {
    const bool closed = signature[0] != 0;
    const auto spokes = static_cast<std::uint32_t>(signature.size() - 1);
    const BaseMesh base = fan_base(closed ? spokes : spokes - 1, closed);
    std::vector<std::uint8_t> creases(base.edge_count());
    for (std::uint32_t e = 0; e < base.edge_count(); ++e)
        for (const auto& [hub, rim] : {std::pair{0, 1}, std::pair{1, 0}})
            if (base.edges()[e].v[hub] == 0) creases[e] = signature[base.edges()[e].v[rim]];
    ListedStencils all = explicit_stencils(base, kFanLevel, options, creases);
    std::erase_if(all.edges, [&](const ListedStencil& s) { return nearest_corner(base, s.edge, 1 << kFanLevel) != 0; });
    return all;
}

}  // namespace

ListedStencils explicit_stencils(const BaseMesh& base, unsigned j, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases) {
    const Level level = make_level(base, j, creases);
    const Names names = grid_names(base, level, 1 << j);
    const DiscreteLifting lifting(level, predict_rule(options.kind), options.s);
    const Tools tools{level, names, lifting, options, ordinary_lifting(options)};
    ListedStencils result;
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        const std::uint32_t a = level.from(level.edges[e].half), b = level.to(level.edges[e].half);
        if (a < base.vertex_count() || b < base.vertex_count() || level.sharp(a) || level.sharp(b))
            result.edges.push_back(stencil_of(tools, e));
    }
    return result;
}

CarriedStencils::CarriedStencils(const GridTopology& topology, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases)
    : topology_(topology), options_(options) {
    const BaseMesh& base = topology.base();
    bool any_sharp = false;
    for (std::uint32_t e = 0; e < base.edge_count(); ++e) {
        sharp_.push_back(base.edges()[e].face[1] == kNone || (!creases.empty() && creases[e] != 0) ? 1 : 0);
        any_sharp = any_sharp || sharp_[e] != 0;
    }
    std::vector<std::uint8_t> seen(std::size_t{3} * base.face_count());
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        for (unsigned c = 0; c < 3; ++c)
            if (seen[std::size_t{3} * f + c] == 0) add_fan({f, c}, seen);
    if (any_sharp) middles_ = {middle_stencils(false, options), middle_stencils(true, options)};
}

/// The next face around the same base vertex; face is kNone beyond a boundary.
CarriedStencils::Corner CarriedStencils::turned(Corner c, bool clockwise) const {
    const unsigned side = clockwise ? c.corner : (c.corner + 2) % 3;
    const std::uint32_t g = topology_.neighbour(c.face, side);
    if (g == kNone) return {kNone, 0};
    const unsigned back = topology_.neighbour_side(c.face, side);
    return {g, clockwise ? (back + 1) % 3 : back};
}

void CarriedStencils::add_fan(Corner start, std::vector<std::uint8_t>& seen) {
    Corner first = start;
    bool closed = false;
    for (Corner c = turned(start, true); c.face != kNone && !closed; c = turned(c, true)) {
        closed = c.face == start.face;
        if (!closed) first = c;
    }
    if (closed) first = start;
    Fan fan{{}, 0};
    std::vector<std::uint8_t> signature{closed ? std::uint8_t{1} : std::uint8_t{0}};
    for (Corner c = first; c.face != kNone; c = turned(c, false)) {
        if (seen[std::size_t{3} * c.face + c.corner] != 0) break;
        seen[std::size_t{3} * c.face + c.corner] = 1;
        fan.corners.push_back(c);
        signature.push_back(sharp_[topology_.base().edge_of(c.face, c.corner)]);
    }
    if (!closed) signature.push_back(1);
    const auto known = std::find(signatures_.begin(), signatures_.end(), signature);
    fan.kind = static_cast<std::size_t>(known - signatures_.begin());
    if (known == signatures_.end()) {
        kinds_.push_back(fan_stencils(signature, options_));
        signatures_.push_back(std::move(signature));
    }
    fans_.push_back(std::move(fan));
}

void CarriedStencils::add_corner(const Fan& fan, int n, ListedStencils& out) const {
    constexpr int m = 1 << kFanLevel;
    const auto place = [&](std::uint32_t i, const Barycentric& b) {
        const auto [face, corner] = fan.corners[i];
        Barycentric r{};
        r[corner] = b[0] + n - m;
        r[(corner + 1) % 3] = b[1];
        r[(corner + 2) % 3] = b[2];
        return GridVertex{face, r[1], r[2]};
    };
    for (const ListedStencil& s : kinds_[fan.kind].edges) out.edges.push_back(moved(s, m, n, place));
}

void CarriedStencils::add_middles(int n, ListedStencils& out) const {
    const BaseMesh& base = topology_.base();
    constexpr int m = 1 << kMiddleLevel, near_end = 1 << (kFanLevel - 1);
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        for (unsigned side = 0; side < 3; ++side) {
            const std::uint32_t e = base.edge_of(f, side);
            if (sharp_[e] == 0) continue;
            const bool boundary = base.edges()[e].face[1] == kNone;
            for (int t = near_end; t < n - near_end; ++t)
                for (const ListedStencil& s : middles_[boundary ? 0 : 1]) {
                    if (s.sharp && !topology_.owns_side(f, side)) continue;
                    out.edges.push_back(moved(s, m, n, [&](std::uint32_t, const Barycentric& b) {
                        Barycentric r{};
                        r[side] = b[0] + (n - m) - (t - kMiddle);
                        r[(side + 1) % 3] = b[1] + t - kMiddle;
                        r[(side + 2) % 3] = b[2];
                        return GridVertex{f, r[1], r[2]};
                    }));
                }
        }
}

ListedStencils CarriedStencils::at_level(unsigned level) const {
    ListedStencils result;
    for (const Fan& fan : fans_) add_corner(fan, 1 << level, result);
    add_middles(1 << level, result);
    return result;
}

}  // namespace mvw
