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

/// The point as far from the anchor corner, on a level of n in place of m points.
GridVertex carried(const BaseMesh& base, GridVertex v, std::uint32_t anchor, int m, int n) {
    Barycentric b = barycentric(v.i, v.k, m);
    for (unsigned c = 0; c < 3; ++c)
        if (base.faces()[v.face][c] == anchor) b[c] += n - m;
    return {v.face, b[1], b[2]};
}
GridEdge carried(const BaseMesh& base, GridEdge e, std::uint32_t anchor, int m, int n) {
    auto ends = edge_ends(e.plane, e.i, e.k, m);
    for (Barycentric& b : ends) {
        const GridVertex v = carried(base, {e.face, b[1], b[2]}, anchor, m, n);
        b = barycentric(v.i, v.k, n);
    }
    return edge_between(e.face, ends[0], ends[1]);
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

ListedStencil carried(const BaseMesh& base, const ListedStencil& s, int m, int n) {
    const std::uint32_t anchor = nearest_corner(base, s.edge, m);
    ListedStencil result = s;
    result.edge = carried(base, s.edge, anchor, m, n);
    for (GridVertex& v : result.ends) v = carried(base, v, anchor, m, n);
    for (auto& t : result.terms) t.vertex = carried(base, t.vertex, anchor, m, n);
    for (auto& t : result.lifts) t.vertex = carried(base, t.vertex, anchor, m, n);
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

/// The stencil shifted along side 0 and turned to side `side` of a face of n.
ListedStencil placed(const ListedStencil& s, std::uint32_t face, unsigned side, int t, int n) {
    constexpr int m = 1 << kMiddleLevel;
    const auto place = [&](const Barycentric& b) {
        Barycentric r{};
        r[side] = b[0] + (n - m) - (t - kMiddle);
        r[(side + 1) % 3] = b[1] + t - kMiddle;
        r[(side + 2) % 3] = b[2];
        return r;
    };
    const auto vertex = [&](const GridVertex& v) {
        const Barycentric b = place(barycentric(v.i, v.k, m));
        return GridVertex{face, b[1], b[2]};
    };
    ListedStencil result = s;
    const auto ends = edge_ends(s.edge.plane, s.edge.i, s.edge.k, m);
    result.edge = edge_between(face, place(ends[0]), place(ends[1]));
    for (GridVertex& v : result.ends) v = vertex(v);
    for (auto& term : result.terms) term.vertex = vertex(term.vertex);
    for (auto& lift : result.lifts) lift.vertex = vertex(lift.vertex);
    return result;
}

}  // namespace

ListedStencils explicit_stencils(const BaseMesh& base, unsigned j, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases) {
    const Level level = make_level(base, j, creases);
    const Names names = grid_names(base, level, 1 << j);
    const DiscreteLifting lifting(level, predict_rule(options.kind), options.s);
    const Tools tools{level, names, lifting, options, ordinary_lifting(options)};
    const auto weights = ten_values(tools.ordinary);
    ListedStencils result;
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        const std::uint32_t a = level.from(level.edges[e].half), b = level.to(level.edges[e].half);
        if (a < base.vertex_count() || b < base.vertex_count() || level.sharp(a) || level.sharp(b)) {
            result.edges.push_back(stencil_of(tools, e));
        } else if (!is_lazy(options.kind)) {
            const auto vertices = ten_vertices(level.ten_points(e));
            for (std::size_t i = 0; i < 10; ++i)
                if (vertices[i] < base.vertex_count())
                    result.corner_lifts.push_back({vertices[i], names.edges[e], weights[i]});
        }
    }
    return result;
}

ListedStencils carried_stencils(const GridTopology& topology, const ListedStencils& explicit_at, unsigned level,
                                const TransformOptions& options, std::span<const std::uint8_t> creases) {
    const BaseMesh& base = topology.base();
    constexpr int m = 1 << kExplicitLevels;
    const int n = 1 << level;
    ListedStencils result;
    for (const ListedStencil& s : explicit_at.edges) result.edges.push_back(carried(base, s, m, n));
    for (const CornerLift& c : explicit_at.corner_lifts)
        result.corner_lifts.push_back({c.base_vertex, carried(base, c.edge, c.base_vertex, m, n), c.weight});
    if (n == m) return result;
    const std::array<std::vector<ListedStencil>, 2> middles{middle_stencils(false, options),
                                                            middle_stencils(true, options)};
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        for (unsigned side = 0; side < 3; ++side) {
            const std::uint32_t e = base.edge_of(f, side);
            const bool boundary = base.edges()[e].face[1] == kNone;
            if (!boundary && (creases.empty() || creases[e] == 0)) continue;
            for (int t = m / 2; t < n - m / 2; ++t)
                for (const ListedStencil& s : middles[boundary ? 0 : 1])
                    if (!s.sharp || topology.owns_side(f, side)) result.edges.push_back(placed(s, f, side, t, n));
        }
    return result;
}

}  // namespace mvw
