#include "codec/remesh/self_parameterization.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>

#include "codec/measure/surface_index.h"
#include "codec/remesh/crossings.h"
#include "codec/remesh/density.h"
#include "codec/remesh/parallel.h"

namespace mvw {

/// An edge that may be collapsed, and what that would cost.
struct SelfParameterization::Candidate {
    double cost = 0;
    std::uint32_t h = 0;
    std::uint32_t from_version = 0, to_version = 0;
    std::uint32_t from = 0, to = 0;
    std::uint32_t strictness = 0;  // index into kStrictness
    bool counts_tips = false;      // cost was at least cost_of_tips when this came on top first
    friend bool operator<(const Candidate& a, const Candidate& b) {  // std::priority_queue: the cheapest on top
        return a.cost != b.cost ? a.cost > b.cost : a.h > b.h;
    }
};

/// How an edge would be collapsed; its surroundings are in ring_.
struct SelfParameterization::Collapse {
    CollapseMode mode{};
    Quadric quadric;              // of both ends
    std::array<Vec3, 3> tries{};  // places for the new vertex, the best first
    std::size_t count = 1;        // of tries
};

/// What a collapse must keep. An edge that is refused comes back later at a higher price and under laxer rules, so
/// that a place that is hard to simplify never makes an easy one pay for it.
struct SelfParameterization::Strictness {
    std::size_t max_ring;
    double min_quality;  // of a triangle after the collapse: 1 equilateral, 0 degenerate
    double min_cosine;   // between a face's normals before and after
    double max_stretch;  // of the chart
    bool may_cross;      // pass through other faces
};

namespace {

constexpr double kRetryPrice = 10;
constexpr std::size_t kMostRing = 64;  // of faces around an edge that collapses
constexpr std::size_t kFewFaces = 30'000;  // where sheets begin to pass through each other, and a look costs little
constexpr double kCornerDegrees = 50;
constexpr double kLeastDensity = 1e-2, kMostDensity = 1e3;  // of the mean

/// 4 sqrt(3) area / sum of squared edges: 1 for equilateral, 0 for degenerate triangles.
double triangle_quality(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double sum = squared_length(b - a) + squared_length(c - b) + squared_length(a - c);
    return sum > 0 ? 2 * std::sqrt(3.0) * length(cross(b - a, c - a)) / sum : 0;
}

/// Where q is least, drawn a little towards the edge's middle so that flat surroundings have an answer, too.
Vec3 best_position(Quadric q, const Vec3& middle) {
    q.add_point(middle, 1e-3 * q.trace());
    return q.minimum(middle);
}

/// Weight of each face's area in the quadrics: errors count for more where the input is denser than elsewhere.
std::vector<double> importance_of_faces(const CollapseMesh& mesh) {
    std::vector<double> weight = areas_around(mesh.positions, mesh.faces);
    const double mean = std::accumulate(weight.begin(), weight.end(), 0.0) / static_cast<double>(weight.size());
    for (double& w : weight) w = std::sqrt(std::clamp(mean / w, kLeastDensity, kMostDensity));
    return weight;
}

/// The mode of collapsing an edge between these kinds, and whether the second end is the one to keep.
bool choose_mode(VertexKind a, VertexKind b, bool line, CollapseMode& mode, bool& keep_second) {
    keep_second = b > a;
    const VertexKind low = std::min(a, b), high = std::max(a, b);
    if (high == VertexKind::Free) return mode = CollapseMode::Free, true;
    if (low == VertexKind::Free) return mode = CollapseMode::KeepEnd, true;
    if (!line || low == VertexKind::Corner) return false;
    mode = high == VertexKind::Corner ? CollapseMode::SlideEnd : CollapseMode::Slide;
    return true;
}

}  // namespace

SelfParameterization::SelfParameterization(const Mesh& mesh, const std::vector<std::uint8_t>& sharp,
                                           const DecimateOptions& options)
    : mesh_(mesh, sharp),
      version_(mesh.positions.size(), 0),

      shape_weight_(options.shape_weight) {
    mesh_.pin_sharp_turns(kCornerDegrees, options.corner_reach);
    init_quadrics();
    std::size_t before = 0;
    do {
        before = mesh_.live_faces();
        if (!reached(options)) sweep(options);
    } while (mesh_.live_faces() * 100 < before * 98);
}

void SelfParameterization::init_quadrics() {
    quadrics_.assign(mesh_.positions.size(), {});
    const std::vector<double> importance = importance_of_faces(mesh_);
    for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f) {
        const Face& t = mesh_.faces[f];
        const Vec3 &a = mesh_.positions[t[0]], &b = mesh_.positions[t[1]], &c = mesh_.positions[t[2]];
        const Vec3 area = cross(b - a, c - a) * 0.5;
        const Vec3 n = normalized(area);
        const double weight = length(area) * importance[f];
        area_ += weight;
        for (const std::uint32_t v : t) quadrics_[v].add_plane(n, a, weight / 3);
        for (std::uint32_t s = 0; s < 3; ++s) {
            const std::uint32_t h = 3 * f + s;
            if (!mesh_.is_line(h)) continue;
            // A wall through the line, perpendicular to the face, holds boundaries and features in place.
            const Vec3 p = mesh_.positions[mesh_.from(h)], e = mesh_.positions[mesh_.to(h)] - p;
            const Vec3 wall = normalized(cross(e, n));
            for (const std::uint32_t v : {mesh_.from(h), mesh_.to(h)})
                quadrics_[v].add_plane(wall, p, squared_length(e) * 0.5 * importance[f]);
        }
    }
}

bool SelfParameterization::evaluate(std::uint32_t h, Candidate& out) const {
    CollapseMode mode{};
    bool keep_second = false;
    const std::uint32_t i = mesh_.from(h), j = mesh_.to(h);
    if (!choose_mode(mesh_.kinds[i], mesh_.kinds[j], mesh_.is_line(h), mode, keep_second)) return false;
    Quadric q = quadrics_[i];
    q += quadrics_[j];
    const double squared = squared_length(mesh_.positions[j] - mesh_.positions[i]);
    const bool stays = mode == CollapseMode::KeepEnd || mode == CollapseMode::SlideEnd;
    double error = 0;
    if (stays) {
        error = q(mesh_.positions[keep_second ? j : i]);
    } else {
        const Vec3 middle = (mesh_.positions[i] + mesh_.positions[j]) * 0.5;
        error = q(best_position(q, middle));
    }
    out = {std::max(error, 0.0) + shape_weight_ * q.trace() * squared, h, version_[i], version_[j], i, j, 0};
    return true;
}

bool SelfParameterization::reached(const DecimateOptions& options) const {
    if (options.target_faces > 0) return mesh_.live_faces() <= options.target_faces;
    return mesh_.live_faces() <= options.max_faces && squared_error_ >= options.error * options.error * area_;
}

void SelfParameterization::sweep(const DecimateOptions& options) {
    static constexpr Strictness kStrictness[] = {
        {12, 0.2, 0.3, 4, false}, {16, 0.08, 0.1, 8, true}, {kMostRing, 0.01, -0.2, 30, true}};
    std::vector<Candidate> edges;
    Candidate c;
    for (std::uint32_t h = 0; h < mesh_.faces.size() * 3; ++h) {
        if (mesh_.faces[h / 3][0] == kNone || (mesh_.twin(h) != kNone && mesh_.twin(h) < h)) continue;
        if (evaluate(h, c)) edges.push_back(c);
    }
    std::priority_queue<Candidate> queue({}, std::move(edges));
    const double all = static_cast<double>(mesh_.faces.size() - std::min(mesh_.faces.size(), options.target_faces));
    std::size_t reported = mesh_.live_faces();
    std::optional<Crossings> crossings;
    while (!queue.empty() && !reached(options)) {
        c = queue.top();
        queue.pop();
        if (mesh_.faces[c.h / 3][0] == kNone || mesh_.from(c.h) != c.from || mesh_.to(c.h) != c.to) continue;
        if (version_[c.from] != c.from_version || version_[c.to] != c.to_version) continue;
        if (!c.counts_tips) {
            c.counts_tips = true;
            if (const double cost = cost_of_tips(c); cost > c.cost) {
                c.cost = cost;
                queue.push(c);
                continue;
            }
        }
        if (!crossings && mesh_.live_faces() <= kFewFaces) crossings.emplace(mesh_);
        if (!try_collapse(c, kStrictness[c.strictness], crossings ? &*crossings : nullptr)) {
            if (++c.strictness == std::size(kStrictness)) continue;
            c.cost *= kRetryPrice;
            queue.push(c);
            continue;
        }
        const std::uint32_t v = ring_.keep;
        const auto push = [&](std::uint32_t h) {
            if (evaluate(h, c)) queue.push(c);
        };
        std::uint32_t h = mesh_.out(v);
        do {
            push(h);
            const std::uint32_t in = CollapseMesh::prev(h);
            h = mesh_.twin(in);
            if (h == kNone) push(in);
        } while (h != kNone && h != mesh_.out(v));
        if (options.progress && reported - mesh_.live_faces() > mesh_.faces.size() / 100) {
            reported = mesh_.live_faces();
            options.progress(static_cast<double>(mesh_.faces.size() - reported) / all);
        }
    }
}

SelfParameterization::Collapse SelfParameterization::prepare(const Candidate& c) {
    Collapse out;
    bool keep_second = false;
    choose_mode(mesh_.kinds[c.from], mesh_.kinds[c.to], mesh_.is_line(c.h), out.mode, keep_second);
    mesh_.ring(c.h, keep_second ? c.to : c.from, ring_);
    out.quadric = quadrics_[c.from];
    out.quadric += quadrics_[c.to];
    const Vec3 &kept = mesh_.positions[ring_.keep], &removed = mesh_.positions[ring_.remove];
    out.tries = {kept, kept, removed};
    if (out.mode == CollapseMode::Free || out.mode == CollapseMode::Slide) {
        out.tries[0] = best_position(out.quadric, (kept + removed) * 0.5);
        out.count = 3;
    }
    return out;
}

/// The planes around the tip of a thin spike all pass by the spike's foot, so quadrics see no loss where it goes. So
/// the ends' own distances from what would be left count, too, by the areas that their quadrics stand for.
double SelfParameterization::cost_of_tips(const Candidate& c) {
    if (!mesh_.can_collapse(c.h)) return 0;
    const Vec3 left = prepare(c).tries[0];
    if (ring_.faces.size() > kMostRing) return 0;
    const std::size_t n = ring_.vertices.size();
    const auto cost_of = [&](std::uint32_t end) {
        const Vec3& p = mesh_.positions[end];
        double squared = std::numeric_limits<double>::infinity();
        for (std::size_t m = 0; m < ring_.faces.size(); ++m) {
            const Vec3 &a = mesh_.positions[ring_.vertices[m]], &b = mesh_.positions[ring_.vertices[(m + 1) % n]];
            const std::array<double, 3> w = closest_on_triangle(p, left, a, b);
            squared = std::min(squared, squared_length(left * w[0] + a * w[1] + b * w[2] - p));
        }
        return quadrics_[end].trace() * squared;
    };
    return cost_of(c.from) + cost_of(c.to);
}

bool SelfParameterization::try_collapse(const Candidate& c, const Strictness& rules, Crossings* crossings) {
    if (!mesh_.can_collapse(c.h)) return false;
    const Collapse collapse = prepare(c);
    if (ring_.faces.size() > rules.max_ring) return false;
    const FlattenLimits limits{rules.max_stretch};
    for (std::size_t k = 0; k < collapse.count; ++k) {
        const Vec3 position = collapse.tries[k];
        if (!keeps_shape(position, rules) || !flatten(mesh_, ring_, position, collapse.mode, limits, chart_)) continue;
        if (crossings != nullptr && !rules.may_cross && crossings->get_more(ring_, position)) continue;
        record(collapse.mode);
        squared_error_ += collapse.quadric(position) - quadrics_[ring_.keep](mesh_.positions[ring_.keep]) -
                          quadrics_[ring_.remove](mesh_.positions[ring_.remove]);
        quadrics_[ring_.keep] = collapse.quadric;
        mesh_.collapse(ring_, position);
        if (crossings != nullptr) crossings->collapsed(ring_);
        ++version_[ring_.keep], ++version_[ring_.remove];
        return true;
    }
    return false;
}

bool SelfParameterization::keeps_shape(const Vec3& position, const Strictness& rules) const {
    const std::size_t n = ring_.vertices.size();
    double worst_before = 1, worst_after = 1;
    for (std::size_t m = 0; m < ring_.faces.size(); ++m) {
        const Vec3 &a = mesh_.positions[ring_.vertices[m]], &b = mesh_.positions[ring_.vertices[(m + 1) % n]];
        const Vec3& old = mesh_.positions[ring_.faces[m].center == 0 ? ring_.keep : ring_.remove];
        const Vec3 n0 = cross(a - old, b - old), n1 = cross(a - position, b - position);
        if (dot(n0, n1) < rules.min_cosine * length(n0) * length(n1)) return false;
        worst_before = std::min(worst_before, triangle_quality(old, a, b));
        worst_after = std::min(worst_after, triangle_quality(position, a, b));
    }
    return worst_after >= rules.min_quality || worst_after >= worst_before;
}

void SelfParameterization::record(CollapseMode mode) {
    Record r{};
    r.uv_begin = static_cast<std::uint32_t>(uv_.size());
    r.face_begin = static_cast<std::uint32_t>(faces_.size());
    r.ring_vertices = static_cast<std::uint16_t>(ring_.vertices.size());
    r.ring_faces = static_cast<std::uint16_t>(ring_.faces.size());
    r.edge_faces = static_cast<std::uint8_t>(ring_.half_edges.size());
    r.stays = mode == CollapseMode::KeepEnd || mode == CollapseMode::SlideEnd;
    uv_.insert(uv_.end(), chart_.begin(), chart_.end());
    for (const RingFace& f : ring_.faces) faces_.push_back({f.face, 0, f.slot, f.center});
    for (std::size_t k = 0; k < ring_.half_edges.size(); ++k) {
        const std::uint32_t h = ring_.half_edges[k];
        faces_.push_back({h / 3, static_cast<std::uint16_t>(ring_.apex[k] % ring_.vertices.size()),
                          static_cast<std::uint8_t>(h % 3), static_cast<std::uint8_t>(mesh_.from(h) != ring_.keep)});
    }
    records_.push_back(r);
}

void SelfParameterization::relocate(const Record& r, std::size_t ring_face, FacePoint& p) const {
    const Uv* uv = uv_.data() + r.uv_begin;
    const RecordFace* faces = faces_.data() + r.face_begin;
    const std::size_t n = r.ring_vertices;
    const std::size_t slot = faces[ring_face].slot;
    const Uv &c = uv[r.stays ? n : n + 2], &a = uv[ring_face], &b = uv[(ring_face + 1) % n];
    const double wc = p.weight[slot], wa = p.weight[(slot + 1) % 3], wb = p.weight[(slot + 2) % 3];
    const double u = wc * c.u + wa * a.u + wb * b.u, v = wc * c.v + wa * a.v + wb * b.v;

    double best = -1e300;
    const std::size_t count = std::size_t{r.ring_faces} + r.edge_faces;
    for (std::size_t k = 0; k < count; ++k) {
        // The face where the point was is the likeliest one.
        const std::size_t t = k == 0 ? ring_face : k <= ring_face ? k - 1 : k;
        const RecordFace& f = faces[t];
        const bool edge_face = t >= r.ring_faces;
        const Uv& x = uv[n + f.center];
        const Uv& y = edge_face ? uv[n + 1 - f.center] : uv[t];
        const Uv& z = edge_face ? uv[f.apex] : uv[(t + 1) % n];
        const double area = doubled_area(x, y, z);
        const double wy = ((u - x.u) * (double{z.v} - x.v) - (double{z.u} - x.u) * (v - x.v)) / area;
        const double wz = ((double{y.u} - x.u) * (v - x.v) - (u - x.u) * (double{y.v} - x.v)) / area;
        const double wx = 1 - wy - wz;
        const double least = std::min({wx, wy, wz});
        if (least <= best) continue;
        best = least;
        p.face = f.face;
        p.weight[f.slot] = wx;
        p.weight[(f.slot + 1u) % 3] = wy;
        p.weight[(f.slot + 2u) % 3] = wz;
        if (best >= 0) return;
    }
    // Outside by rounding: the nearest triangle's border.
    double sum = 0;
    for (double& w : p.weight) sum += w = std::max(w, 0.0);
    for (double& w : p.weight) w /= sum;
}

void SelfParameterization::to_input_serial(std::span<FacePoint> points) const {
    // Points of one face form a list: a collapse is undone for all points on its faces at once.
    std::vector<std::uint32_t> head(mesh_.faces.size(), kNone), next(points.size());
    const auto add = [&](std::uint32_t i) {
        next[i] = head[points[i].face];
        head[points[i].face] = i;
    };
    for (std::uint32_t i = 0; i < points.size(); ++i) add(i);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> moved;  // point, ring face
    for (std::size_t k = records_.size(); k-- > 0;) {
        const Record& r = records_[k];
        moved.clear();
        for (std::uint32_t m = 0; m < r.ring_faces; ++m) {
            std::uint32_t& first = head[faces_[r.face_begin + m].face];
            for (std::uint32_t i = first; i != kNone; i = next[i]) moved.emplace_back(i, m);
            first = kNone;
        }
        for (const auto& [i, m] : moved) {
            relocate(r, m, points[i]);
            add(i);
        }
    }
}

void SelfParameterization::to_input(std::vector<FacePoint>& points, unsigned threads) const {
    parallel_slices(points.size(), threads, [&](std::size_t begin, std::size_t end) {
        to_input_serial(std::span(points).subspan(begin, end - begin));
    });
}

}  // namespace mvw
