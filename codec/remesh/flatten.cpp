#include "codec/remesh/flatten.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "codec/measure/surface_index.h"

namespace mvw {

namespace {

constexpr std::size_t kMaxConformalRing = 40;  // larger rings go to the linear-time way at once
constexpr int kMaxUnknowns = 2 * static_cast<int>(kMaxConformalRing + 3);
constexpr double kMaxRingWeight = 0.7;  // of a ring vertex in the new vertex's place
constexpr double kMinHeight = 1e-3;     // of the longest edge: flatter triangles count as this high

struct Vec2 {
    double u = 0, v = 0;
};

/// The ring as a little mesh of its own: vertices 0..n-1 on the ring, n kept, n+1 removed, n+2 new.
struct Patch {
    std::size_t n = 0;
    std::vector<Vec3> points;
    std::vector<std::array<std::uint32_t, 3>> before, after;
    std::vector<Vec2> uv;
    /// Where the new vertex lies on the surface before: weights over three of its vertices.
    std::array<std::uint32_t, 3> anchor{};
    std::array<double, 3> anchor_weight{};
    std::size_t line_begin = 0, line_end = 0;  // ring positions where the line through the edge comes in and goes out
};

/// Ring position of the line's continuation at `center` (0 kept, 1 removed); kNone where there is none.
std::uint32_t line_neighbor(const CollapseMesh& mesh, const EdgeRing& ring, unsigned center) {
    const std::size_t n = ring.vertices.size();
    for (std::size_t m = 0; m < ring.faces.size(); ++m) {
        if (ring.faces[m].center != center) continue;
        const std::uint32_t h = ring.faces[m].face * 3 + ring.faces[m].slot;
        if (mesh.is_line(h)) return static_cast<std::uint32_t>(m);
        if (mesh.is_line(CollapseMesh::prev(h))) return static_cast<std::uint32_t>((m + 1) % n);
    }
    return kNone;
}

void build_patch(const CollapseMesh& mesh, const EdgeRing& ring, const Vec3& position, CollapseMode mode, Patch& p) {
    p.n = ring.vertices.size();
    p.points.clear(), p.before.clear(), p.after.clear();
    for (const std::uint32_t v : ring.vertices) p.points.push_back(mesh.positions[v]);
    p.points.push_back(mesh.positions[ring.keep]);
    p.points.push_back(mesh.positions[ring.remove]);
    p.points.push_back(position);
    const auto n = static_cast<std::uint32_t>(p.n);
    const bool stays = mode == CollapseMode::KeepEnd || mode == CollapseMode::SlideEnd;
    for (std::uint32_t m = 0; m < ring.faces.size(); ++m) {
        const std::uint32_t a = m, b = (m + 1) % n;
        p.before.push_back({n + ring.faces[m].center, a, b});
        p.after.push_back({stays ? n : n + 2, a, b});
    }
    for (std::size_t k = 0; k < ring.half_edges.size(); ++k) {
        const bool from_kept = mesh.from(ring.half_edges[k]) == ring.keep;
        p.before.push_back({from_kept ? n : n + 1, from_kept ? n + 1 : n, ring.apex[k] % n});
    }
    p.uv.assign(p.n + 3, {});
}

/// Ties the new vertex to the surface point nearest to it, on the line where the collapse slides along one: its place
/// in the chart follows from its place in space, so that corners and ridges stay under the base's vertices.
void anchor_new_vertex(Patch& p, CollapseMode mode) {
    const auto n = static_cast<std::uint32_t>(p.n);
    p.anchor = {n, n, n};
    p.anchor_weight = {1, 0, 0};
    if (mode == CollapseMode::KeepEnd || mode == CollapseMode::SlideEnd) return;
    double best = std::numeric_limits<double>::infinity();
    const auto offer = [&](const std::array<std::uint32_t, 3>& t) {
        const std::array<double, 3> w =
            closest_on_triangle(p.points[n + 2], p.points[t[0]], p.points[t[1]], p.points[t[2]]);
        const Vec3 at = p.points[t[0]] * w[0] + p.points[t[1]] * w[1] + p.points[t[2]] * w[2];
        const double distance = squared_length(at - p.points[n + 2]);
        if (distance < best) best = distance, p.anchor = t, p.anchor_weight = w;
    };
    if (mode == CollapseMode::Slide) {
        const auto begin = static_cast<std::uint32_t>(p.line_begin), end = static_cast<std::uint32_t>(p.line_end);
        offer({begin, n, n}), offer({n, n + 1, n + 1}), offer({n + 1, end, end});
    } else {
        for (const auto& t : p.before) offer(t);
    }
    // Not on the ring itself: the triangles after the collapse need some room.
    for (std::size_t k = 0; k < 3; ++k) {
        if (p.anchor[k] >= n || p.anchor_weight[k] <= kMaxRingWeight) continue;
        const double rest = 1 - p.anchor_weight[k];
        const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
        const double share = rest > 0 ? p.anchor_weight[a] / rest : p.anchor[a] >= n ? 1 : 0;
        p.anchor_weight[k] = kMaxRingWeight;
        p.anchor_weight[a] = (1 - kMaxRingWeight) * share;
        p.anchor_weight[b] = (1 - kMaxRingWeight) * (1 - share);
    }
}

/// Corners of a triangle in its own plane: (0,0), (x1,0), (x2,y2), slivers raised to kMinHeight.
struct Flat {
    double x1, x2, y2;
};
Flat lay_flat(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 e = b - a, f = c - a;
    const double x1 = length(e);
    const double longest = std::sqrt(std::max({squared_length(e), squared_length(f), squared_length(c - b)}));
    if (!(x1 > 0)) return {longest * kMinHeight, 0, longest};
    const double x2 = dot(e, f) / x1;
    const double y2 = length(cross(e, f)) / x1;
    return {x1, x2, std::max(y2, longest * kMinHeight)};
}

/// Least-squares conformal map (Levy et al. 2002) of all triangles before and after, some coordinates given.
class ConformalSystem {
 public:
    explicit ConformalSystem(std::size_t vertices) : known_(vertices * 2, 0), value_(vertices * 2, 0.0) {}
    void fix_u(std::size_t v, double u) { known_[2 * v] = 1, value_[2 * v] = u; }
    void fix_v(std::size_t v, double w) { known_[2 * v + 1] = 1, value_[2 * v + 1] = w; }

    bool solve(const Patch& p, std::vector<Vec2>& uv) {
        std::vector<int>& row = row_;
        row.assign(known_.size(), -1);
        int unknowns = 0;
        for (std::size_t k = 0; k < known_.size(); ++k)
            if (!known_[k]) row[k] = unknowns++;
        H_.setZero(unknowns, unknowns);
        r_.setZero(unknowns);
        for (const auto& t : p.before) add(p, t);
        for (const auto& t : p.after) add(p, t);
        const Eigen::LDLT<Matrix> factor(H_);
        if (factor.info() != Eigen::Success) return false;
        const Vector x = factor.solve(r_);
        for (std::size_t v = 0; v < uv.size(); ++v) {
            uv[v].u = row[2 * v] < 0 ? value_[2 * v] : x[row[2 * v]];
            uv[v].v = row[2 * v + 1] < 0 ? value_[2 * v + 1] : x[row[2 * v + 1]];
            if (!std::isfinite(uv[v].u) || !std::isfinite(uv[v].v)) return false;
        }
        return true;
    }

 private:
    using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;
    using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnknowns, 1>;

    void add(const Patch& p, const std::array<std::uint32_t, 3>& t) {
        const Flat f = lay_flat(p.points[t[0]], p.points[t[1]], p.points[t[2]]);
        const double scale = 1 / (f.x1 * f.y2);
        const std::array<Vec2, 3> W{{{f.x2 - f.x1, f.y2}, {-f.x2, -f.y2}, {f.x1, 0}}};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                const double re = (W[i].u * W[j].u + W[i].v * W[j].v) * scale;
                const double im = (W[i].v * W[j].u - W[i].u * W[j].v) * scale;
                add_block(p, t[i], t[j], re, im);
            }
        }
    }
    /// Spreads the pair's 2x2 block over the anchor's vertices where one of them is the new vertex.
    void add_block(const Patch& p, std::size_t i, std::size_t j, double re, double im) {
        const std::size_t fresh = p.n + 2;
        if (i == fresh) {
            for (std::size_t k = 0; k < 3; ++k)
                if (const double w = p.anchor_weight[k]; w > 0) add_block(p, p.anchor[k], j, re * w, im * w);
        } else if (j == fresh) {
            for (std::size_t k = 0; k < 3; ++k)
                if (const double w = p.anchor_weight[k]; w > 0) add_block(p, i, p.anchor[k], re * w, im * w);
        } else {
            put(2 * i, 2 * j, re), put(2 * i, 2 * j + 1, im);
            put(2 * i + 1, 2 * j, -im), put(2 * i + 1, 2 * j + 1, re);
        }
    }
    void put(std::size_t i, std::size_t j, double h) {
        if (row_[i] < 0) return;
        if (row_[j] < 0)
            r_[row_[i]] -= h * value_[j];
        else
            H_(row_[i], row_[j]) += h;
    }

    std::vector<std::uint8_t> known_;
    std::vector<double> value_;
    std::vector<int> row_;
    Matrix H_;
    Vector r_;
};

bool flatten_conformally(Patch& p, CollapseMode mode) {
    if (p.n > kMaxConformalRing) return false;
    ConformalSystem system(p.n + 3);
    const std::size_t keep = p.n, remove = p.n + 1, fresh = p.n + 2;
    const auto distance = [&](std::size_t a, std::size_t b) { return length(p.points[a] - p.points[b]); };
    system.fix_u(fresh, 0), system.fix_v(fresh, 0);  // no unknown of its own: it follows its anchor
    if (mode == CollapseMode::Slide) {
        const std::size_t begin = p.line_begin, end = p.line_end;
        for (const std::size_t v : {begin, end, keep, remove}) system.fix_v(v, 0);
        system.fix_u(begin, 0);
        system.fix_u(end, distance(begin, keep) + distance(keep, remove) + distance(remove, end));
    } else if (mode == CollapseMode::SlideEnd) {
        system.fix_u(keep, 0), system.fix_v(keep, 0), system.fix_v(remove, 0), system.fix_v(p.line_end, 0);
        system.fix_u(p.line_end, distance(keep, remove) + distance(remove, p.line_end));
    } else {
        std::size_t far = 0;
        for (std::size_t m = 1; m < p.n; ++m)
            if (distance(keep, m) > distance(keep, far)) far = m;
        system.fix_u(keep, 0), system.fix_v(keep, 0);
        system.fix_u(far, distance(keep, far)), system.fix_v(far, 0);
    }
    if (!system.solve(p, p.uv)) return false;
    p.uv[fresh] = {};
    for (std::size_t k = 0; k < 3; ++k) {
        p.uv[fresh].u += p.anchor_weight[k] * p.uv[p.anchor[k]].u;
        p.uv[fresh].v += p.anchor_weight[k] * p.uv[p.anchor[k]].v;
    }
    return true;
}

/// The triangle check of both configurations, on the coordinates as they are stored.
bool sound(const Patch& p, const EdgeRing& ring, CollapseMode mode, const FlattenLimits& limits,
           const std::vector<Uv>& uv) {
    for (const auto& t : p.before) {
        const double area = doubled_area(uv[t[0]], uv[t[1]], uv[t[2]]);
        double longest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Uv &a = uv[t[k]], &b = uv[t[(k + 1) % 3]];
            longest = std::max(longest,
                               (double{a.u} - b.u) * (double{a.u} - b.u) + (double{a.v} - b.v) * (double{a.v} - b.v));
        }
        if (!(area > 1e-5 * longest)) return false;
    }
    double turn = 0;
    for (const auto& t : p.after) {
        const Uv &a = uv[t[0]], &b = uv[t[1]], &c = uv[t[2]];
        const double area = doubled_area(a, b, c);
        if (!(area > 0)) return false;
        const Flat f = lay_flat(p.points[t[0]], p.points[t[1]], p.points[t[2]]);
        // Jacobian of plane coordinates by surface coordinates; its singular values' ratio from trace and determinant.
        const double ux = (double{b.u} - a.u) / f.x1, vx = (double{b.v} - a.v) / f.x1;
        const double uy = ((double{c.u} - a.u) - ux * f.x2) / f.y2, vy = ((double{c.v} - a.v) - vx * f.x2) / f.y2;
        const double det = ux * vy - uy * vx, norm = ux * ux + uy * uy + vx * vx + vy * vy;
        const double s = limits.max_stretch;
        if (!(det > 0) || norm > det * (s + 1 / s)) return false;
        turn += std::atan2(area, (double{b.u} - a.u) * (double{c.u} - a.u) + (double{b.v} - a.v) * (double{c.v} - a.v));
    }
    const double full = ring.closed ? 2 * std::numbers::pi : mode == CollapseMode::Slide ? std::numbers::pi : 0;
    return full == 0 ? turn < 2 * std::numbers::pi : std::abs(turn - full) < 0.1;
}

void round_uv(const Patch& p, std::vector<Uv>& uv) {
    uv.resize(p.uv.size());
    for (std::size_t k = 0; k < uv.size(); ++k) uv[k] = {static_cast<float>(p.uv[k].u), static_cast<float>(p.uv[k].v)};
}

}  // namespace

bool flatten(const CollapseMesh& mesh, const EdgeRing& ring, const Vec3& position, CollapseMode mode,
             const FlattenLimits& limits, std::vector<Uv>& uv) {
    thread_local Patch p;
    build_patch(mesh, ring, position, mode, p);
    if (mode == CollapseMode::Slide || mode == CollapseMode::SlideEnd) {
        const std::uint32_t at_keep = line_neighbor(mesh, ring, 0), at_remove = line_neighbor(mesh, ring, 1);
        if (at_remove == kNone || (mode == CollapseMode::Slide && at_keep == kNone)) return false;
        if (at_remove == at_keep) return false;
        p.line_begin = at_keep, p.line_end = at_remove;
    }
    anchor_new_vertex(p, mode);
    if (!flatten_conformally(p, mode)) return false;
    round_uv(p, uv);
    return sound(p, ring, mode, limits, uv);
}

}  // namespace mvw
