#include "codec/transform/patch/listed_stencils.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include "codec/transform/patch/shared_rows.h"

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
    const std::optional<DiscreteLifting>& lifting;  // none for lazy transforms
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

void add_stencil(const Tools& tools, std::uint32_t e, ListedStencils& out) {
    const auto name = [&](std::uint32_t v) { return tools.names.vertices[v]; };
    const TransformOptions& options = tools.options;
    std::vector<Term> terms;
    predict_terms(tools.level, e, predict_rule(options.kind), options.s, terms);
    for (const Term& t : terms) out.terms.push_back({name(t.vertex), t.position, t.shape});
    const bool ordinary = is_ordinary(tools.level, e);
    const auto add_ten = [&](const TenWeights& weights, const auto& add) {
        const auto vertices = ten_vertices(tools.level.ten_points(e));
        const auto values = ten_values(weights);
        for (std::size_t i = 0; i < 10; ++i) add(name(vertices[i]), values[i]);
    };
    if (options.kind == TransformKind::Vector && ordinary)
        add_ten(kVectorShape, [&](const GridVertex& v, double value) { out.terms.push_back({v, 0, value}); });
    if (!is_lazy(options.kind) && ordinary)
        add_ten(tools.ordinary, [&](const GridVertex& v, double value) { out.lifts.push_back({v, value}); });
    if (!is_lazy(options.kind) && !ordinary) {
        std::vector<LiftTerm> lifts;
        tools.lifting->weights(e, options.kind == TransformKind::Loop && options.loop_template == 4, lifts);
        for (const LiftTerm& t : lifts) out.lifts.push_back({name(t.vertex), t.weight});
    }
    out.end_edge(tools.names.edges[e], tools.level.edges[e].sharp);
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

/// Where points of a small mesh lie in another one: face i from its corner 0 on as corners[(first + i) % their number]
/// says, and `by` further.
struct Placing {
    std::span<const FaceCorner> corners;
    std::size_t first;
    Barycentric by;
    int from, to;  // segments a side

    [[nodiscard]] GridVertex operator()(std::uint32_t i, const Barycentric& b) const {
        const auto [face, corner] = corners[(first + i) % corners.size()];
        Barycentric r{};
        for (unsigned c = 0; c < 3; ++c) r[(corner + c) % 3] = b[c] + by[c];
        return {face, r[1], r[2]};
    }
    [[nodiscard]] GridVertex operator()(const GridVertex& v) const {
        return (*this)(v.face, barycentric(v.i, v.k, from));
    }
    [[nodiscard]] GridEdge operator()(const GridEdge& e) const {
        const auto ends = edge_ends(e.plane, e.i, e.k, from);
        const GridVertex a = (*this)(e.face, ends[0]), b = (*this)(e.face, ends[1]);
        return edge_between(a.face, barycentric(a.i, a.k, to), barycentric(b.i, b.k, to));
    }
};

/// Adds stencil e of `from` with each of its points moved.
void add_moved(const ListedStencils& from, std::size_t e, const Placing& place, ListedStencils& out) {
    for (const auto& t : from.terms_of(e)) out.terms.push_back({place(t.vertex), t.position, t.shape});
    for (const auto& l : from.lifts_of(e)) out.lifts.push_back({place(l.vertex), l.weight});
    out.end_edge(place(from.edges[e].edge), from.edges[e].sharp);
}

/// The listed stencils of a level of a small mesh: those of its edges for which keep(edge) holds.
template <typename Keep>
ListedStencils stencils_where(const BaseMesh& base, unsigned j, const TransformOptions& options,
                              std::span<const std::uint8_t> creases, Keep keep) {
    const Level level = make_level(base, j, creases);
    const Names names = grid_names(base, level, 1 << j);
    std::optional<DiscreteLifting> lifting;
    if (!is_lazy(options.kind)) lifting.emplace(level, predict_rule(options.kind), options.s);
    const Tools tools{level, names, lifting, options, ordinary_lifting(options)};
    ListedStencils result;
    for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
        const std::uint32_t a = level.from(level.edges[e].half), b = level.to(level.edges[e].half);
        const bool listed = a < base.vertex_count() || b < base.vertex_count() || level.sharp(a) || level.sharp(b);
        if (listed && keep(names.edges[e])) add_stencil(tools, e, result);
    }
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
ListedStencils middle_stencils(bool crease, const TransformOptions& options) {
    const BaseMesh base = middle_base(crease);
    std::vector<std::uint8_t> creases(base.edge_count());
    creases[0] = crease ? 1 : 0;
    return stencils_where(base, kMiddleLevel, options, creases,
                          [](const GridEdge& e) { return e.face == 0 && e.i == kMiddle && e.k == 0; });
}

/// A fan around base vertex 0: closed, or open with one spoke more than faces.
BaseMesh fan_base(std::uint32_t faces, bool closed) {
    std::vector<Face> list;
    for (std::uint32_t i = 0; i < faces; ++i) list.push_back({0, 1 + i, 1 + (closed ? (i + 1) % faces : i + 1)});
    return BaseMesh::create(faces + (closed ? 1 : 2), std::move(list)).value();
}

/// What lies nearer to the middle of the fan than to its rim.
ListedStencils fan_stencils(const std::vector<float>& signature, const TransformOptions& options) {
    const bool closed = signature[0] != 0;
    const auto spokes = static_cast<std::uint32_t>(signature.size() - 1);
    const BaseMesh base = fan_base(closed ? spokes : spokes - 1, closed);
    std::vector<std::uint8_t> creases(base.edge_count());
    for (std::uint32_t e = 0; e < base.edge_count(); ++e)
        for (const auto& [hub, rim] : {std::pair{0, 1}, std::pair{1, 0}})
            if (base.edges()[e].v[hub] == 0) creases[e] = signature[base.edges()[e].v[rim]] != 0 ? 1 : 0;
    return stencils_where(base, kFanLevel, options, creases,
                          [&](const GridEdge& e) { return nearest_corner(base, e, 1 << kFanLevel) == 0; });
}

/// A closed fan around base vertex 0, and beyond the end of its first spoke, vertex 1, what makes that regular or not.
BaseMesh closed_at_first_spoke(std::uint32_t spokes, bool regular) {
    const std::uint32_t outwards = regular ? 3 : 4;  // edges from vertex 1
    std::vector<Face> list;
    for (std::uint32_t i = 0; i < spokes; ++i) list.push_back({0, 1 + i, 1 + (i + 1) % spokes});
    const std::uint32_t rim = 1 + spokes;
    list.push_back({1, spokes, rim});
    for (std::uint32_t t = 0; t + 1 < outwards; ++t) list.push_back({1, rim + t, rim + t + 1});
    list.push_back({2, 1, rim + outwards - 1});
    return BaseMesh::create(rim + outwards, std::move(list)).value();
}

/// The edge from the middle of such a fan along that spoke.
ListedStencils spoke_stencils(std::size_t spokes, bool regular, const TransformOptions& options) {
    return stencils_where(closed_at_first_spoke(static_cast<std::uint32_t>(spokes), regular), kSpokeLevel, options, {},
                          [](const GridEdge& e) { return e.face == 0 && e.plane == kH && e.i == 0 && e.k == 0; });
}

/// As spoke_stencils(), solved for once a process: bases have the same few valences, and files may have many parts.
std::shared_ptr<const ListedStencils> known_spoke(std::size_t spokes, bool regular, const TransformOptions& options) {
    using Key = std::tuple<TransformKind, double, bool, unsigned, std::size_t, bool>;
    constexpr std::size_t kMostSpokes = 32, kMostKnown = 256;
    static std::mutex mutex;
    static std::map<Key, std::shared_ptr<const ListedStencils>> known;
    const Key key{options.kind, options.s, options.table1_weights, options.loop_template, spokes, regular};
    {
        const std::lock_guard lock(mutex);
        if (const auto found = known.find(key); found != known.end()) return found->second;
    }
    auto made = std::make_shared<const ListedStencils>(spoke_stencils(spokes, regular, options));
    const std::lock_guard lock(mutex);
    if (spokes <= kMostSpokes && known.size() < kMostKnown) known.emplace(key, made);
    return made;
}

}  // namespace

ListedStencils explicit_stencils(const BaseMesh& base, unsigned j, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases) {
    return stencils_where(base, j, options, creases, [](const GridEdge&) { return true; });
}

CarriedStencils::CarriedStencils(const GridTopology& topology, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases)
    : topology_(topology), options_(options) {
    const BaseMesh& base = topology.base();
    for (std::uint32_t e = 0; e < base.edge_count(); ++e)
        sharp_.push_back(base.edges()[e].face[1] == kNone || (!creases.empty() && creases[e] != 0) ? 1 : 0);
    std::vector<std::uint8_t> seen(std::size_t{3} * base.face_count());
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        for (unsigned c = 0; c < 3; ++c)
            if (seen[std::size_t{3} * f + c] == 0) add_fan({f, c}, seen);
}

/// The next face around the same base vertex; face is kNone beyond a boundary.
FaceCorner CarriedStencils::turned(FaceCorner c, bool clockwise) const {
    const unsigned side = clockwise ? c.corner : (c.corner + 2) % 3;
    const std::uint32_t g = topology_.neighbour(c.face, side);
    if (g == kNone) return {kNone, 0};
    const unsigned back = topology_.neighbour_side(c.face, side);
    return {g, clockwise ? (back + 1) % 3 : back};
}

void CarriedStencils::add_fan(FaceCorner start, std::vector<std::uint8_t>& seen) {
    FaceCorner first = start;
    bool closed = false;
    for (FaceCorner c = turned(start, true); c.face != kNone && !closed; c = turned(c, true)) {
        closed = c.face == start.face;
        if (!closed) first = c;
    }
    if (closed) first = start;
    Fan fan{{}, closed};
    for (FaceCorner c = first; c.face != kNone; c = turned(c, false)) {
        if (seen[std::size_t{3} * c.face + c.corner] != 0) break;
        seen[std::size_t{3} * c.face + c.corner] = 1;
        fan.corners.push_back(c);
    }
    fans_.push_back(std::move(fan));
}

std::uint32_t CarriedStencils::hub(const Fan& fan) const {
    return topology_.base().faces()[fan.corners[0].face][fan.corners[0].corner];
}

/// 1 where it is closed, then 1 for each spoke that is sharp; else 0. Floats, which SharedRows keeps.
std::vector<float> CarriedStencils::signature(const Fan& fan) const {
    std::vector<float> result{fan.closed ? 1.0f : 0.0f};
    for (const FaceCorner& c : fan.corners) result.push_back(sharp_[topology_.base().edge_of(c.face, c.corner)]);
    if (!fan.closed) result.push_back(1);
    return result;
}

const ListedStencils& CarriedStencils::spoke(std::size_t spokes, bool regular) const {
    const std::lock_guard lock(finding_spoke_);
    const auto [found, is_new] = spokes_.try_emplace({spokes, regular});
    if (is_new) found->second = known_spoke(spokes, regular, options_);
    return *found->second;
}

/// As fan_stencils() of a closed fan of no sharp spoke.
ListedStencils CarriedStencils::smooth_fan(std::size_t spokes) const {
    constexpr int from = 1 << kSpokeLevel, to = 1 << kFanLevel;
    std::vector<FaceCorner> corners;
    for (std::uint32_t f = 0; f < spokes; ++f) corners.push_back({f, 0});
    ListedStencils result;
    for (std::size_t s = 0; s < spokes; ++s)
        add_moved(spoke(spokes, true), 0, {corners, s, {to - from, 0, 0}, from, to}, result);
    return result;
}

/// What levels from kFanLevel on are made of.
void CarriedStencils::make_kinds() {
    if (!kinds_.empty()) return;
    std::vector<float> numbers;
    SharedRows signatures(numbers);
    std::vector<std::size_t> kind_at;  // by where its signature begins
    for (const Fan& fan : fans_) {
        const std::vector<float> row = signature(fan);
        const std::uint32_t place = signatures.place(row);
        if (place >= kind_at.size()) {
            kind_at.resize(numbers.size(), kinds_.size());
            const bool smooth =
                fan.closed && fan.corners.size() > 2 && std::find(row.begin() + 1, row.end(), 1) == row.end();
            kinds_.push_back(smooth ? smooth_fan(fan.corners.size()) : fan_stencils(row, options_));
        }
        kind_of_fan_.push_back(kind_at[place]);
    }
    if (std::find(sharp_.begin(), sharp_.end(), 1) != sharp_.end())
        middles_ = {middle_stencils(false, options_), middle_stencils(true, options_)};
}

/// What kSpokeLevel has around base vertices near which nothing is sharp.
class CarriedStencils::Spokes {
 public:
    explicit Spokes(const CarriedStencils& carried)
        : carried_(carried), base_(carried.topology_.base()), plain_(base_.vertex_count(), 1) {
        valence_.resize(base_.vertex_count());
        for (std::uint32_t e = 0; e < base_.edge_count(); ++e)
            for (const std::uint32_t v : base_.edges()[e].v) {
                ++valence_[v];
                if (carried.sharp_[e] != 0) plain_[v] = 0;
            }
        for (const Fan& fan : carried.fans_)
            if (fan.corners.size() != valence_[carried.hub(fan)]) plain_[carried.hub(fan)] = 0;
    }
    /// Whether nothing that the spokes' edges see is sharp. Two faces on each other see nothing but themselves.
    [[nodiscard]] bool is_smooth(const Fan& fan) const {
        return fan.corners.size() > 2 && plain_[carried_.hub(fan)] != 0 &&
               std::all_of(fan.corners.begin(), fan.corners.end(),
                           [&](const FaceCorner& c) { return plain_[end_of_spoke(c)] != 0; });
    }
    void add(const Fan& fan, ListedStencils& out) const {
        constexpr int n = 1 << kSpokeLevel;
        const std::size_t spokes = fan.corners.size();
        for (std::size_t s = 0; s < spokes; ++s) {
            const bool regular = valence_[end_of_spoke(fan.corners[s])] == 6;
            add_moved(carried_.spoke(spokes, regular), 0, {fan.corners, s, {}, n, n}, out);
        }
    }

 private:
    [[nodiscard]] std::uint32_t end_of_spoke(const FaceCorner& c) const {
        return base_.faces()[c.face][(c.corner + 1) % 3];
    }

    const CarriedStencils& carried_;
    const BaseMesh& base_;
    std::vector<std::uint8_t> plain_;     // of each base vertex: one fan, no sharp edge
    std::vector<std::uint32_t> valence_;  // of each base vertex
};

ListedStencils CarriedStencils::at_spoke_level() const {
    const BaseMesh& base = topology_.base();
    const Spokes spokes(*this);
    std::vector<std::uint8_t> smooth(base.vertex_count(), 1);  // also where no face is
    for (const Fan& fan : fans_)
        if (!spokes.is_smooth(fan)) smooth[hub(fan)] = 0;
    ListedStencils result;
    if (std::find(smooth.begin(), smooth.end(), 0) != smooth.end())
        result = stencils_where(base, kSpokeLevel, options_, sharp_, [&](const GridEdge& e) {
            return smooth[nearest_corner(base, e, 1 << kSpokeLevel)] == 0;
        });
    for (const Fan& fan : fans_)
        if (smooth[hub(fan)] != 0) spokes.add(fan, result);
    return result;
}

void CarriedStencils::add_corner(std::size_t fan, int n, ListedStencils& out) const {
    constexpr int m = 1 << kFanLevel;
    const ListedStencils& kind = kinds_[kind_of_fan_[fan]];
    for (std::size_t e = 0; e < kind.edges.size(); ++e)
        add_moved(kind, e, {fans_[fan].corners, 0, {n - m, 0, 0}, m, n}, out);
}

void CarriedStencils::add_middles(int n, ListedStencils& out) const {
    const BaseMesh& base = topology_.base();
    constexpr int m = 1 << kMiddleLevel, near_end = 1 << (kFanLevel - 1);
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        for (unsigned side = 0; side < 3; ++side) {
            const std::uint32_t e = base.edge_of(f, side);
            if (sharp_[e] == 0) continue;
            const bool boundary = base.edges()[e].face[1] == kNone;
            const ListedStencils& middle = middles_[boundary ? 0 : 1];
            for (int t = near_end; t < n - near_end; ++t) {
                const FaceCorner at{f, side};
                const Placing place{{&at, 1}, 0, {(n - m) - (t - kMiddle), t - kMiddle, 0}, m, n};
                for (std::size_t i = 0; i < middle.edges.size(); ++i)
                    if (!middle.edges[i].sharp || topology_.owns_side(f, side)) add_moved(middle, i, place, out);
            }
        }
}

ListedStencils CarriedStencils::at_level(unsigned level) {
    make_kinds();
    ListedStencils result;
    for (std::size_t fan = 0; fan < fans_.size(); ++fan) add_corner(fan, 1 << level, result);
    add_middles(1 << level, result);
    return result;
}

}  // namespace mvw
