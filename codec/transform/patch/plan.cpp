#include "codec/transform/patch/plan.h"

#include <algorithm>
#include <optional>
#include <set>

#include "codec/transform/patch/listed_stencils.h"

namespace mvw {

namespace {

struct Slot {
    EdgePlane plane;
    int i, k;
    friend auto operator<=>(const Slot&, const Slot&) = default;
};

/// The thirty edges that lift the vertex (0, 0): those of kernels.cpp's lift, by plane.
constexpr Slot kLiftedBy[] = {{kH, 0, 0},  {kH, -1, 0}, {kH, 0, -1}, {kH, -1, 1}, {kH, 1, -1}, {kH, -1, -1},
                              {kH, 0, 1},  {kH, -2, 1}, {kH, 1, 0},  {kH, -2, 0}, {kV, 0, 0},  {kV, 0, -1},
                              {kV, 1, -1}, {kV, -1, 0}, {kV, 1, 0},  {kV, 1, -2}, {kV, -1, 1}, {kV, -1, -1},
                              {kV, 0, 1},  {kV, 0, -2}, {kD, -1, 0}, {kD, 0, -1}, {kD, 0, 0},  {kD, -1, -1},
                              {kD, -1, 1}, {kD, 1, -1}, {kD, -2, 0}, {kD, 0, -2}, {kD, -2, 1}, {kD, 1, -2}};

bool inside_or_on(const Barycentric& b) {
    return b[0] >= 0 && b[1] >= 0 && b[2] >= 0;
}
bool is_corner(const Barycentric& b, int n) {
    return inside_or_on(b) && (b[0] == n || b[1] == n || b[2] == n);
}

/// Ghost edges that the lift of a patch's vertices reads, base vertices excepted: sorted. Those that touch a corner
/// apart.
struct GhostEdges {
    std::vector<Slot> legitimate, at_corners;
};

GhostEdges ghost_edges(int n) {
    std::set<Slot> slots, at_corners;
    const auto visit = [&](int i, int k) {
        if (is_corner(barycentric(i, k, n), n)) return;
        for (const Slot& s : kLiftedBy) {
            const Slot at{s.plane, i + s.i, k + s.k};
            const auto ends = edge_ends(at.plane, at.i, at.k, n);
            if (inside_or_on(ends[0]) && inside_or_on(ends[1])) continue;
            (is_corner(ends[0], n) || is_corner(ends[1], n) ? at_corners : slots).insert(at);
        }
    };
    // Only vertices near a side read ghosts.
    for (int i = 0; i <= n; ++i)
        for (int k = 0; i + k <= n; ++k)
            if (i <= 2 || k <= 2 || n - i - k <= 2) visit(i, k);
    return {{slots.begin(), slots.end()}, {at_corners.begin(), at_corners.end()}};
}

/// The side that a ghost edge lies beyond.
unsigned side_beyond(const std::array<Barycentric, 2>& ends) {
    for (unsigned s = 0; s < 2; ++s)
        if (std::min(ends[0][(s + 2) % 3], ends[1][(s + 2) % 3]) < 0) return s;
    return 2;
}

class PlanBuilder {
 public:
    PlanBuilder(const GridTopology& topology, unsigned level) : topology_(topology), n_(1 << level) {
        plan_.level = level;
        plan_.layout = Layout(level);
    }

    LevelPlan build(const ListedStencils& stencils, const TransformOptions& options,
                    std::span<const std::uint8_t> creases) {
        copy_vertices();
        list_edges(stencils);  // before copy_edges(): the place of zero lies behind the listed edges
        copy_edges();
        list_corners(options, creases);
        return std::move(plan_);
    }

 private:
    [[nodiscard]] std::uint32_t faces() const { return topology_.base().face_count(); }
    [[nodiscard]] std::uint32_t local(const GridEdge& e) const {
        return e.plane * plan_.layout.plane + plan_.layout.at(e.i, e.k);
    }
    [[nodiscard]] std::uint32_t offset(const GridVertex& v) const {
        return v.face * 3 * plan_.layout.plane + plan_.layout.at(v.i, v.k);
    }
    [[nodiscard]] std::uint32_t offset(const GridEdge& e) const { return e.face * 9 * plan_.layout.plane + local(e); }
    [[nodiscard]] std::uint32_t owned(const GridVertex& v) const { return offset(topology_.owner(v, n_)); }
    [[nodiscard]] std::uint32_t owned(const GridEdge& e) const { return offset(topology_.owner(e, n_)); }

    /// Grid point at distance `row` inside (or, negative, beyond) side s, t along it.
    [[nodiscard]] Barycentric beside(unsigned s, int t, int row) const {
        Barycentric b{};
        b[(s + 1) % 3] = t;
        b[(s + 2) % 3] = row;
        b[s] = n_ - t - row;
        return b;
    }

    void copy_vertices() {
        for (unsigned s = 0; s < 3; ++s)
            for (unsigned t = 0; t < 3; ++t)
                for (const bool owned_side : {false, true}) {
                    auto& copies = plan_.vertex_copies[s][t][owned_side ? 1 : 0];
                    const auto add = [&](const Barycentric& b) {
                        const Barycentric from = across(b, s, t);
                        copies.push_back({plan_.layout.at(b[1], b[2]), plan_.layout.at(from[1], from[2])});
                    };
                    for (int i = 1; i < n_ && !owned_side; ++i) add(beside(s, i, 0));
                    for (int i = 2; i < n_; ++i) add(beside(s, i, -1));
                }
        for (unsigned s = 0; s < 3; ++s)
            for (int t = 1; t <= n_; ++t) {
                const Barycentric ghost = beside(s, t, -1), on = beside(s, t - 1, 0);
                plan_.folded_vertices[s].push_back(
                    {plan_.layout.at(ghost[1], ghost[2]), plan_.layout.at(on[1], on[2])});
            }
        plan_.first_vertex_fix.push_back(0);
        for (std::uint32_t f = 0; f < faces(); ++f) {
            for (unsigned c = 0; c < 3; ++c) fix_vertex(f, topology_.corner(f, c, n_));
            for (unsigned s = 0; s < 3; ++s) {
                if (topology_.neighbour(f, s) == kNone) continue;
                for (const int t : {1, n_}) {
                    const Barycentric b = beside(s, t, -1);
                    fix_vertex(f, {f, b[1], b[2]});
                    if (n_ == 1) break;
                }
            }
            plan_.first_vertex_fix.push_back(static_cast<std::uint32_t>(plan_.vertex_fixes.size()));
        }
    }
    void fix_vertex(std::uint32_t f, const GridVertex& v) {
        const std::uint32_t to = f * 3 * plan_.layout.plane + plan_.layout.at(v.i, v.k), from = owned(v);
        if (to != from) plan_.vertex_fixes.push_back({to, from});
    }

    void copy_edges() {
        const GhostEdges ghosts = ghost_edges(n_);
        for (const Slot& slot : ghosts.at_corners)
            plan_.zero_at_corners.push_back(local({0, slot.plane, slot.i, slot.k}));
        std::array<std::vector<Slot>, 3> fixed;
        for (unsigned s = 0; s < 3; ++s)
            for (unsigned t = 0; t < 3; ++t) {
                const auto add = [&](const Slot& slot, bool own, bool foreign) {
                    auto ends = edge_ends(slot.plane, slot.i, slot.k, n_);
                    for (Barycentric& b : ends) b = across(b, s, t);
                    const Copy copy{local({0, slot.plane, slot.i, slot.k}), local(edge_between(0, ends[0], ends[1]))};
                    if (own) plan_.edge_copies[s][t][1].push_back(copy);
                    if (foreign) plan_.edge_copies[s][t][0].push_back(copy);
                };
                for (int i = 0; i < n_; ++i) {
                    const GridEdge e = edge_between(0, beside(s, i, 0), beside(s, i + 1, 0));
                    add({e.plane, e.i, e.k}, false, true);
                }
                for (const Slot& slot : ghosts.legitimate) {
                    auto ends = edge_ends(slot.plane, slot.i, slot.k, n_);
                    if (side_beyond(ends) != s) continue;
                    const int z0 = ends[0][(s + 2) % 3], z1 = ends[1][(s + 2) % 3];
                    if (t == 0) plan_.zero_beyond[s].push_back(local({0, slot.plane, slot.i, slot.k}));
                    for (Barycentric& b : ends) b = across(b, s, t);
                    // The vertices of a side that is not owned are copies: only the first row of ghosts serves others.
                    if (between_sides(ends))
                        add(slot, true, std::max(z0, z1) == 0);
                    else if (t == 0)
                        fixed[s].push_back(slot);
                }
            }
        plan_.first_edge_fix.push_back(0);
        for (std::uint32_t f = 0; f < faces(); ++f) {
            for (unsigned s = 0; s < 3; ++s) {
                if (topology_.neighbour(f, s) == kNone) continue;
                for (const Slot& slot : fixed[s]) {
                    const GridEdge to{f, slot.plane, slot.i, slot.k}, from = topology_.owner(to, n_);
                    plan_.edge_fixes.push_back(
                        {offset(to), from.face == kNone ? plan_.zero_slot(faces()) : offset(from)});
                }
            }
            plan_.first_edge_fix.push_back(static_cast<std::uint32_t>(plan_.edge_fixes.size()));
        }
    }
    /// Within the triangle and along none of its sides.
    static bool between_sides(const std::array<Barycentric, 2>& ends) {
        if (!inside_or_on(ends[0]) || !inside_or_on(ends[1])) return false;
        for (unsigned c = 0; c < 3; ++c)
            if (ends[0][c] == 0 && ends[1][c] == 0) return false;
        return true;
    }

    void list_edges(const ListedStencils& stencils) {
        std::vector<const ListedStencil*> order;
        for (const ListedStencil& s : stencils.edges) order.push_back(&s);
        const auto face_of = [&](const ListedStencil* s) { return topology_.owner(s->edge, n_).face; };
        std::stable_sort(order.begin(), order.end(),
                         [&](const auto* a, const auto* b) { return face_of(a) < face_of(b); });
        plan_.first_listed.assign(faces() + 1, 0);
        for (const ListedStencil* s : order) {
            ++plan_.first_listed[face_of(s) + 1];
            for (const auto& t : s->terms)
                plan_.terms.push_back({owned(t.vertex), static_cast<float>(t.position), static_cast<float>(t.shape)});
            plan_.listed.push_back({owned(s->edge),
                                    {owned(s->ends[0]), owned(s->ends[1])},
                                    static_cast<std::uint32_t>(plan_.terms.size()),
                                    !s->sharp});
        }
        for (std::uint32_t f = 0; f < faces(); ++f) plan_.first_listed[f + 1] += plan_.first_listed[f];
        list_targets(stencils, order);
    }

    void list_targets(const ListedStencils& stencils, const std::vector<const ListedStencil*>& order) {
        struct Entry {
            std::uint32_t vertex, detail;
            float weight;
        };
        std::vector<Entry> entries;
        for (std::uint32_t i = 0; i < order.size(); ++i)
            for (const auto& lift : order[i]->lifts)
                entries.push_back({owned(lift.vertex), plan_.listed_slot(i, faces()), static_cast<float>(lift.weight)});
        std::vector<std::uint32_t> corner_offsets;
        for (std::uint32_t v = 0; v < topology_.base().vertex_count(); ++v) {
            const auto [face, at] = topology_.corner_owner(v);
            corner_offsets.push_back(face == kNone ? kNone : offset(topology_.corner(face, at, n_)));
        }
        for (const CornerLift& c : stencils.corner_lifts)
            entries.push_back({corner_offsets[c.base_vertex], owned(c.edge), static_cast<float>(c.weight)});
        std::stable_sort(entries.begin(), entries.end(),
                         [](const Entry& a, const Entry& b) { return a.vertex < b.vertex; });
        // Offsets rise with the owning patch, so that this order is also that of the patches.
        plan_.first_target.assign(faces() + 1, 0);
        for (const Entry& e : entries) {
            if (plan_.targets.empty() || plan_.targets.back().vertex != e.vertex) {
                plan_.targets.push_back({e.vertex, 0});
                ++plan_.first_target[e.vertex / (3 * plan_.layout.plane) + 1];
            }
            plan_.sources.push_back({e.detail, e.weight});
            plan_.targets.back().last_source = static_cast<std::uint32_t>(plan_.sources.size());
        }
        for (std::uint32_t f = 0; f < faces(); ++f) plan_.first_target[f + 1] += plan_.first_target[f];
    }

    void list_corners(const TransformOptions& options, std::span<const std::uint8_t> creases) {
        const BaseMesh& base = topology_.base();
        struct Ring {
            std::vector<std::array<std::uint32_t, 2>> triangles;
            std::vector<std::uint32_t> neighbours, slots, sharp_neighbours, sharp_slots;
        };
        std::vector<Ring> rings(base.vertex_count());
        for (std::uint32_t f = 0; f < faces(); ++f)
            for (unsigned c = 0; c < 3; ++c) {
                const Barycentric a = beside(c, 1, 0), b = beside((c + 2) % 3, n_ - 1, 0);
                rings[base.faces()[f][c]].triangles.push_back(
                    {owned(GridVertex{f, a[1], a[2]}), owned(GridVertex{f, b[1], b[2]})});
            }
        for (std::uint32_t e = 0; e < base.edge_count(); ++e) {
            const BaseEdge& edge = base.edges()[e];
            const bool sharp = edge.face[1] == kNone || (!creases.empty() && creases[e] != 0);
            for (unsigned end = 0; end < 2; ++end) {
                const Barycentric corner = beside(edge.side[0], end == 0 ? 0 : n_, 0);
                const Barycentric next = beside(edge.side[0], end == 0 ? 1 : n_ - 1, 0);
                const std::uint32_t neighbour = owned(GridVertex{edge.face[0], next[1], next[2]});
                const std::uint32_t slot = offset(edge_between(edge.face[0], corner, next));
                Ring& ring = rings[edge.v[end]];
                ring.neighbours.push_back(neighbour);
                ring.slots.push_back(slot);
                if (!sharp) continue;
                ring.sharp_neighbours.push_back(neighbour);
                ring.sharp_slots.push_back(slot);
            }
        }
        for (std::uint32_t v = 0; v < base.vertex_count(); ++v) {
            const Ring& ring = rings[v];
            const auto [face, at] = topology_.corner_owner(v);
            Corner corner{face == kNone ? kNone : offset(topology_.corner(face, at, n_)), 0, 0, 0};
            const bool sharp = !ring.sharp_slots.empty(), curve = ring.sharp_slots.size() == 2;
            const auto& neighbours = sharp ? ring.sharp_neighbours : ring.neighbours;
            const auto& slots = sharp ? ring.sharp_slots : ring.slots;
            if (!sharp || curve) {
                append(plan_.corner_neighbours, neighbours);
                append(plan_.corner_loop_edges, slots);
            }
            append(plan_.corner_triangles, ring.triangles);
            corner.last_triangle = static_cast<std::uint32_t>(plan_.corner_triangles.size());
            corner.last_neighbour = static_cast<std::uint32_t>(plan_.corner_neighbours.size());
            corner.last_loop_edge = static_cast<std::uint32_t>(plan_.corner_loop_edges.size());
            if (predict_rule(options.kind) == PredictRule::Loop && !ring.slots.empty()) {
                const LoopEven rule = loop_even(ring.slots.size(), sharp, curve);
                corner.loop_a = static_cast<float>(rule.a);
                corner.loop_b = static_cast<float>(rule.b);
            }
            plan_.corners.push_back(corner);
        }
    }
    template <typename T>
    static void append(std::vector<T>& to, const std::vector<T>& from) {
        to.insert(to.end(), from.begin(), from.end());
    }

    const GridTopology& topology_;
    int n_;
    LevelPlan plan_;
};

}  // namespace

std::vector<LevelPlan> make_plans(const GridTopology& topology, unsigned levels, const TransformOptions& options,
                                  std::span<const std::uint8_t> creases) {
    std::vector<LevelPlan> plans;
    std::optional<CarriedStencils> carried;
    if (levels > kFanLevel) carried.emplace(topology, options, creases);
    for (unsigned j = 0; j < levels; ++j)
        plans.push_back(
            PlanBuilder(topology, j)
                .build(j < kFanLevel ? explicit_stencils(topology.base(), j, options, creases) : carried->at_level(j),
                       options, creases));
    return plans;
}

}  // namespace mvw
