#include "codec/transform/patch/plan.h"

#include <algorithm>
#include <memory>
#include <tuple>

#include "codec/transform/patch/listed_stencils.h"
#include "codec/transform/patch/shared_rows.h"
#include "codec/transform/tables.h"

namespace mvw {

namespace {

class PlanBuilder {
 public:
    PlanBuilder(const GridTopology& topology, unsigned level, const TransformOptions& options)
        : topology_(topology), n_(1 << level), options_(options) {
        plan_.level = level;
        plan_.layout = Layout(level, lanes_for(faces()));
        if (!is_lazy(options.kind) || predict_rule(options.kind) == PredictRule::Loop)
            plan_.lift_program = make_lift_program(plan_.layout);
    }

    LevelPlan build(const ListedStencils& stencils, std::span<const std::uint8_t> creases) {
        copy_vertices();
        fix_vertices();
        place_runs();
        list_edges(stencils);
        list_targets(stencils);
        list_corners(creases);
        plan_.fixes.shrink_to_fit();
        plan_.collected_fixes.shrink_to_fit();
        plan_.listed.shrink_to_fit();
        plan_.listed_vertices.shrink_to_fit();
        plan_.listed_weights.shrink_to_fit();
        plan_.source_weights.shrink_to_fit();
        plan_.targets.shrink_to_fit();
        plan_.sources.shrink_to_fit();
        plan_.corner_triangles.shrink_to_fit();
        plan_.corner_neighbours.shrink_to_fit();
        plan_.corner_loop_edges.shrink_to_fit();
        return std::move(plan_);
    }

 private:
    [[nodiscard]] std::uint32_t faces() const { return topology_.base().face_count(); }
    [[nodiscard]] std::uint32_t offset(const GridVertex& v) const {
        return static_cast<std::uint32_t>(plan_.patch_vertices(v.face)) + plan_.layout.at(v.i, v.k);
    }
    [[nodiscard]] std::uint32_t offset(const GridEdge& e) const {
        return static_cast<std::uint32_t>(plan_.patch_edges(e.face)) + plan_.layout.edge(e.plane, e.i, e.k);
    }
    [[nodiscard]] GridVertex owned(const GridVertex& v) const { return topology_.owner(v, n_); }

    /// Grid point at distance `row` inside (or, negative, beyond) side s, t along it.
    [[nodiscard]] Barycentric beside(unsigned s, int t, int row) const {
        Barycentric b{};
        b[(s + 1) % 3] = t;
        b[(s + 2) % 3] = row;
        b[s] = n_ - t - row;
        return b;
    }

    void copy_vertices() {
        const Layout& layout = plan_.layout;
        const auto copy = [&](const Barycentric& to, const Barycentric& from) {
            return Copy{layout.at(to[1], to[2]), layout.at(from[1], from[2])};
        };
        for (unsigned s = 0; s < 3; ++s) {
            for (unsigned t = 0; t < 3; ++t) {
                for (int i = 1; i < n_; ++i)
                    plan_.side_vertices[s][t].push_back(copy(beside(s, i, 0), across(beside(s, i, 0), s, t)));
                for (int i = 2; i < n_; ++i)
                    plan_.ghosts[s][t].push_back(copy(beside(s, i, -1), across(beside(s, i, -1), s, t)));
            }
            for (int t = 0; t <= n_; ++t) plan_.side_points[s].push_back(layout.side_vertex(s, t));
            for (int t = 0; t < n_; ++t) plan_.side_edges[s].push_back(layout.side_edge(s, t));
            for (int t = 1; t <= n_; ++t) plan_.folded[s].push_back(copy(beside(s, t, -1), beside(s, t - 1, 0)));
        }
    }

    /// Corners, and ghosts at both ends of each side.
    void fix_vertices() {
        std::vector<std::vector<std::uint32_t>> collected(faces());
        plan_.first_fix.push_back(0);
        for (std::uint32_t f = 0; f < faces(); ++f) {
            const auto fix = [&](const GridVertex& v) {
                const GridVertex from = owned(v);
                const Copy c{offset(v), offset(from)};
                if (c.to == c.from) return;
                collected[from.face].push_back(static_cast<std::uint32_t>(plan_.fixes.size()));
                plan_.fixes.push_back(c);
            };
            for (unsigned c = 0; c < 3; ++c) fix(topology_.corner(f, c, n_));
            for (unsigned s = 0; s < 3; ++s) {
                if (topology_.neighbour(f, s) == kNone) continue;
                for (const int t : {1, n_}) {
                    const Barycentric b = beside(s, t, -1);
                    fix({f, b[1], b[2]});
                    if (n_ == 1) break;
                }
            }
            plan_.first_fix.push_back(static_cast<std::uint32_t>(plan_.fixes.size()));
        }
        plan_.first_collected_fix.push_back(0);
        for (const auto& of_patch : collected) {
            append(plan_.collected_fixes, of_patch);
            plan_.first_collected_fix.push_back(static_cast<std::uint32_t>(plan_.collected_fixes.size()));
        }
    }

    /// Runs go row by row over the finer grid (semi_regular.h).
    void place_runs() {
        const auto add = [&](std::vector<std::uint32_t>& places, std::uint32_t at) {
            for (unsigned c = 0; c < 3; ++c) places.push_back(at + c * plan_.layout.lanes);
        };
        const auto visit_run = [](int n, const auto& visit) {
            for (int i = 1; i < n; ++i)
                for (int k = 1; k < n - i; k += i % 2 == 1 ? 1 : 2) visit(i, k);
        };
        visit_run(2 * n_, [&](int i, int k) {
            const EdgePlane plane = i % 2 == 0 ? kV : k % 2 == 0 ? kH : kD;
            add(plan_.detail_places, plan_.layout.edge(plane, i / 2, k / 2));
        });
        plan_.vertex_places.resize(plan_.level);
        for (unsigned j = 1; j <= plan_.level; ++j) {
            const int step = n_ >> j;
            visit_run(1 << j,
                      [&](int i, int k) { add(plan_.vertex_places[j - 1], plan_.layout.at(i * step, k * step)); });
        }
        for (unsigned s = 0; s < 3; ++s) {
            for (const std::uint32_t edge : plan_.side_edges[s]) add(plan_.side_detail_places[s], edge);
            plan_.side_vertex_places[s].resize(plan_.level);
            for (unsigned j = 1; j <= plan_.level; ++j)
                for (int step = n_ >> j, t = step; t < n_; t += 2 * step)
                    add(plan_.side_vertex_places[s][j - 1], plan_.side_points[s][static_cast<std::size_t>(t)]);
        }
    }

    /// Moves items into the order of face_of(item), equal ones as they were, and says where each face's begin.
    template <typename T, typename FaceOf>
    PatchRuns sort_by_face(std::vector<T>& items, FaceOf face_of) const {
        PatchRuns first(faces() + 1);
        for (const T& item : items) ++first[face_of(item) + 1];
        for (std::uint32_t f = 0; f < faces(); ++f) first[f + 1] += first[f];
        PatchRuns place(first.begin(), first.end() - 1);
        std::vector<T> sorted(items.size());
        for (const T& item : items) sorted[place[face_of(item)]++] = item;
        items = std::move(sorted);
        return first;
    }

    void list_edges(const ListedStencils& stencils) {
        for (std::uint32_t e = 0; e < stencils.edges.size(); ++e)
            order_.push_back({topology_.owner(stencils.edges[e].edge, n_), e});
        plan_.first_listed = sort_by_face(order_, [](const Listed& l) { return l.edge.face; });
        SharedRows rows(plan_.listed_weights);
        std::vector<float> weights;
        plan_.listed.reserve(order_.size());
        plan_.listed_vertices.reserve(stencils.terms.size());
        for (const auto& [edge, stencil] : order_) {
            weights.clear();
            for (const auto& t : stencils.terms_of(stencil)) {
                plan_.listed_vertices.push_back(offset(owned(t.vertex)));
                weights.push_back(static_cast<float>(t.position));
                weights.push_back(static_cast<float>(t.shape));
            }
            plan_.listed.push_back({plan_.layout.edge(edge.plane, edge.i, edge.k) + edge.face % plan_.layout.lanes,
                                    static_cast<std::uint32_t>(plan_.listed_vertices.size()), rows.place(weights),
                                    stencils.edges[stencil].sharp ? 0u : 1u});
        }
    }

    void list_targets(const ListedStencils& stencils) {
        struct Entry {
            std::uint32_t face, vertex, listed;
            float weight;
        };
        std::vector<Entry> entries;
        entries.reserve(stencils.lifts.size());
        for (std::uint32_t i = 0; i < order_.size(); ++i)
            for (const auto& lift : stencils.lifts_of(order_[i].stencil)) {
                const GridVertex v = owned(lift.vertex);
                entries.push_back({v.face, offset(v), i, static_cast<float>(lift.weight)});
            }
        const PatchRuns first_entry = sort_by_face(entries, [](const Entry& e) { return e.face; });
        plan_.first_target.push_back(0);
        plan_.sources.reserve(entries.size());
        SharedRows rows(plan_.source_weights);
        std::vector<float> weights;
        for (std::uint32_t f = 0; f < faces(); ++f) {
            const std::span<Entry> of_face =
                std::span(entries).subspan(first_entry[f], first_entry[f + 1] - first_entry[f]);
            // By weight within a vertex, so that many have the same row of weights.
            std::sort(of_face.begin(), of_face.end(), [](const Entry& a, const Entry& b) {
                return std::tie(a.vertex, a.weight, a.listed) < std::tie(b.vertex, b.weight, b.listed);
            });
            for (std::size_t first = 0, last = 0; first < of_face.size(); first = last) {
                weights.clear();
                for (; last < of_face.size() && of_face[last].vertex == of_face[first].vertex; ++last) {
                    plan_.sources.push_back(of_face[last].listed);
                    weights.push_back(of_face[last].weight);
                }
                plan_.targets.push_back(
                    {of_face[first].vertex, static_cast<std::uint32_t>(plan_.sources.size()), rows.place(weights)});
            }
            plan_.first_target.push_back(static_cast<std::uint32_t>(plan_.targets.size()));
        }
    }

    void list_corners(std::span<const std::uint8_t> creases) {
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
                    {offset(owned({f, a[1], a[2]})), offset(owned({f, b[1], b[2]}))});
            }
        for (std::uint32_t e = 0; e < base.edge_count(); ++e) {
            const BaseEdge& edge = base.edges()[e];
            const bool sharp = edge.face[1] == kNone || (!creases.empty() && creases[e] != 0);
            for (unsigned end = 0; end < 2; ++end) {
                const Barycentric corner = beside(edge.side[0], end == 0 ? 0 : n_, 0);
                const Barycentric next = beside(edge.side[0], end == 0 ? 1 : n_ - 1, 0);
                const std::uint32_t neighbour = offset(owned({edge.face[0], next[1], next[2]}));
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
            const PredictRule rule = predict_rule(options_.kind);
            const bool seeded = rule == PredictRule::Seeded || rule == PredictRule::SeededNormal;
            if (!sharp || curve) {
                if (seeded || options_.kind == TransformKind::Vector) append(plan_.corner_neighbours, neighbours);
                if (rule == PredictRule::Loop) append(plan_.corner_loop_edges, slots);
            }
            if (options_.local_frames || rule == PredictRule::SeededNormal)
                append(plan_.corner_triangles, ring.triangles);
            corner.last_triangle = static_cast<std::uint32_t>(plan_.corner_triangles.size());
            corner.last_neighbour = static_cast<std::uint32_t>(plan_.corner_neighbours.size());
            corner.last_loop_edge = static_cast<std::uint32_t>(plan_.corner_loop_edges.size());
            if (rule == PredictRule::Loop && !ring.slots.empty()) {
                const LoopEven even = loop_even(ring.slots.size(), sharp, curve);
                corner.loop_a = static_cast<float>(even.a);
                corner.loop_b = static_cast<float>(even.b);
            }
            if (!sharp)
                corner.vector_even =
                    ring.slots.size() == 6 ? 1.0f : static_cast<float>(kVectorEvenIrregular / kVectorEven);
            plan_.corners.push_back(corner);
        }
    }
    template <typename T>
    static void append(std::vector<T>& to, const std::vector<T>& from) {
        to.insert(to.end(), from.begin(), from.end());
    }

    const GridTopology& topology_;
    int n_;
    const TransformOptions& options_;
    LevelPlan plan_;
    struct Listed {
        GridEdge edge;  // its owner's
        std::uint32_t stencil;
    };
    std::vector<Listed> order_;  // by face
};

template <typename T>
std::size_t bytes_of(const std::vector<T>& v) {
    return v.capacity() * sizeof(T);
}

}  // namespace

std::size_t LevelPlan::memory_bytes() const {
    std::size_t bytes = bytes_of(lift_program.points) + bytes_of(lift_program.edges) + bytes_of(fixes) +
                        bytes_of(collected_fixes) + bytes_of(first_fix) + bytes_of(first_collected_fix) +
                        bytes_of(detail_places) + bytes_of(listed) + bytes_of(first_listed) +
                        bytes_of(listed_vertices) + bytes_of(listed_weights) + bytes_of(source_weights) +
                        bytes_of(targets) + bytes_of(first_target) + bytes_of(sources) + bytes_of(corners) +
                        bytes_of(corner_triangles) + bytes_of(corner_neighbours) + bytes_of(corner_loop_edges);
    for (std::size_t s = 0; s < 3; ++s) {
        bytes += bytes_of(folded[s]) + bytes_of(side_points[s]) + bytes_of(side_edges[s]);
        for (std::size_t t = 0; t < 3; ++t) bytes += bytes_of(side_vertices[s][t]) + bytes_of(ghosts[s][t]);
    }
    for (const auto& places : vertex_places) bytes += bytes_of(places);
    for (std::size_t s = 0; s < 3; ++s) {
        bytes += bytes_of(side_detail_places[s]);
        for (const auto& places : side_vertex_places[s]) bytes += bytes_of(places);
    }
    return bytes;
}

ListedEdges LevelPlan::listed_edges(std::uint32_t f) const {
    const std::uint32_t first = first_listed[f];
    return {std::span(listed).subspan(first, first_listed[f + 1] - first), listed_vertices.data(),
            first == 0 ? 0 : listed[first - 1].last_vertex, listed_weights.data()};
}

LiftTargets LevelPlan::lift_targets(std::uint32_t f) const {
    const std::uint32_t first = first_target[f];
    return {std::span(targets).subspan(first, first_target[f + 1] - first), sources.data(),
            first == 0 ? 0 : targets[first - 1].last_source, source_weights.data()};
}

TransformTables::TransformTables(const BaseMesh& base, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases)
    : topology_(std::make_unique<GridTopology>(base)), options_(options), creases_(creases.begin(), creases.end()) {}
TransformTables::~TransformTables() = default;

std::size_t TransformTables::jobs(unsigned levels) {
    if (plans_.size() < levels) plans_.resize(levels);
    levels_ = levels;
    jobs_.clear();
    const auto has_plan = [&](unsigned j) { return plans_[j] != nullptr; };
    unsigned fine = kFanLevel;
    while (fine < levels && has_plan(fine)) ++fine;
    if (fine < levels) jobs_.push_back(fine);  // the longest one first
    for (unsigned j = std::min(levels, kFanLevel); j-- > 0;)
        if (!has_plan(j)) jobs_.push_back(j);
    if (!carried_ && levels > kSpokeLevel) carried_ = std::make_unique<CarriedStencils>(*topology_, options_, creases_);
    return jobs_.size();
}

void TransformTables::make(std::size_t job) {
    const unsigned first = jobs_[job];
    const auto build = [&](unsigned j, const ListedStencils& stencils) {
        plans_[j] = std::make_unique<LevelPlan>(PlanBuilder(*topology_, j, options_).build(stencils, creases_));
    };
    if (first < kSpokeLevel) return build(first, explicit_stencils(topology_->base(), first, options_, creases_));
    if (first == kSpokeLevel) return build(first, carried_->at_spoke_level());
    for (unsigned j = first; j < levels_; ++j)
        if (!plans_[j]) build(j, carried_->at_level(j));
}

void TransformTables::make_all(unsigned levels) {
    for (std::size_t job = 0, count = jobs(levels); job < count; ++job) make(job);
}

}  // namespace mvw
