#include "codec/remesh/simplify.h"

#include <algorithm>

#include "codec/remesh/features.h"

namespace mvw {

/// An edge that may be collapsed, and what that would cost.
struct Simplifier::Candidate {
    double cost = 0;
    std::uint32_t h = 0;
    std::uint32_t from = 0, to = 0;
    std::uint32_t from_version = 0, to_version = 0;
    Vec3 position;
    friend bool operator<(const Candidate& a, const Candidate& b) {  // a heap: the cheapest on top
        return a.cost != b.cost ? a.cost > b.cost : a.h > b.h;
    }
};

namespace {

constexpr double kDraw = 1e-3;   // of a quadric's weight, towards the edge's middle, where it has no one least point
constexpr double kShape = 1e-6;  // of an edge's squared length: which of the edges of a plane goes first
constexpr double kLeastCosine = 0.2;  // between a face's normals before and after
constexpr std::size_t kPatience = 3;  // candidates looked at in a round, times the collapses wanted
constexpr double kNoSide = 1e-10;     // of a face's longest squared edge: twice the area of one that faces nowhere

/// Material borders alone: what is sharp, the quadrics see.
std::vector<std::uint8_t> borders(const Mesh& mesh) {
    if (mesh.materials.empty()) return {};
    constexpr double kNoAngle = 181;
    return feature_half_edges(mesh, {kNoAngle, 0, 0});
}

}  // namespace

Simplifier::Simplifier(const Mesh& mesh, double stay)
    : input_(mesh),
      stay_(stay),
      mesh_(mesh, borders(mesh)),
      quadrics_(mesh.positions.size()),
      version_(mesh.positions.size(), 0) {
    init_quadrics();
    Candidate c;
    for (std::uint32_t h = 0; h < mesh_.faces.size() * 3; ++h)
        if ((mesh_.twin(h) == kNone || mesh_.twin(h) > h) && rate(h, c)) queue_.push_back(c);
    std::make_heap(queue_.begin(), queue_.end());
}

Simplifier::~Simplifier() = default;

void Simplifier::init_quadrics() {
    for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f) {
        const Face& t = mesh_.faces[f];
        const Vec3 &a = mesh_.positions[t[0]], &b = mesh_.positions[t[1]], &c = mesh_.positions[t[2]];
        const Vec3 area = cross(b - a, c - a) * 0.5;
        const Vec3 n = normalized(area);
        for (const std::uint32_t v : t) quadrics_[v].add_plane(n, a, length(area) / 3);
        for (std::uint32_t s = 0; s < 3; ++s) {
            const std::uint32_t h = 3 * f + s;
            if (!mesh_.is_line(h)) continue;
            // A wall through the line, perpendicular to the face, holds it in place.
            const Vec3 p = mesh_.positions[mesh_.from(h)], e = mesh_.positions[mesh_.to(h)] - p;
            const Vec3 wall = normalized(cross(e, n));
            for (const std::uint32_t v : {mesh_.from(h), mesh_.to(h)})
                quadrics_[v].add_plane(wall, p, squared_length(e) * 0.5);
        }
    }
}

/// Ends on lines stay on these: a free end goes to the other one's place, two ends of one line anywhere.
bool Simplifier::rate(std::uint32_t h, Candidate& out) const {
    const std::uint32_t i = mesh_.from(h), j = mesh_.to(h);
    const VertexKind a = mesh_.kinds[i], b = mesh_.kinds[j];
    const bool moves = a == b && (a == VertexKind::Free || (a == VertexKind::Line && mesh_.is_line(h)));
    const bool along = a == VertexKind::Free || b == VertexKind::Free || mesh_.is_line(h);
    if (!moves && (!along || a == b)) return false;
    Quadric q = quadrics_[i];
    q += quadrics_[j];
    const Vec3 &p = mesh_.positions[i], &r = mesh_.positions[j];
    out = {0, h, i, j, version_[i], version_[j], a > b ? p : r};
    if (moves) {
        const Vec3 middle = (p + r) * 0.5;
        Quadric drawn = q;
        drawn.add_point(middle, kDraw * q.trace());
        out.position = drawn.minimum(middle);
        double least = stay_ * q(out.position);
        for (const Vec3& end : {p, r})
            if (q(end) <= least) least = q(end), out.position = end;
    }
    out.cost = std::max(q(out.position), 0.0) + kShape * q.trace() * squared_length(p - r);
    return true;
}

/// Whether no face around the edge turns over, nor comes to face nowhere that did not.
bool Simplifier::keeps_sides(const Vec3& position) const {
    const std::size_t n = ring_.vertices.size();
    for (std::size_t m = 0; m < ring_.faces.size(); ++m) {
        const Vec3 &a = mesh_.positions[ring_.vertices[m]], &b = mesh_.positions[ring_.vertices[(m + 1) % n]];
        const Vec3& old = mesh_.positions[ring_.faces[m].center == 0 ? ring_.keep : ring_.remove];
        const Vec3 before = cross(a - old, b - old), after = cross(a - position, b - position);
        const auto longest = [&](const Vec3& c) {
            return std::max({squared_length(a - b), squared_length(a - c), squared_length(b - c)});
        };
        if (length(before) <= kNoSide * longest(old)) continue;
        if (length(after) <= kNoSide * longest(position)) return false;
        if (dot(before, after) < kLeastCosine * length(before) * length(after)) return false;
    }
    return true;
}

void Simplifier::push_around(std::uint32_t v) {
    const auto push = [&](std::uint32_t h) {
        Candidate c;
        if (!rate(h, c)) return;
        queue_.push_back(c);
        std::push_heap(queue_.begin(), queue_.end());
    };
    std::uint32_t h = mesh_.out(v);
    do {
        push(h);
        const std::uint32_t in = CollapseMesh::prev(h);
        h = mesh_.twin(in);
        if (h == kNone) push(in);
    } while (h != kNone && h != mesh_.out(v));
}

bool Simplifier::is_current(const Candidate& c) const {
    if (mesh_.faces[c.h / 3][0] == kNone || mesh_.from(c.h) != c.from || mesh_.to(c.h) != c.to) return false;
    return version_[c.from] == c.from_version && version_[c.to] == c.to_version;
}

bool Simplifier::may_collapse(const Candidate& c) {
    if (!mesh_.can_collapse(c.h)) return false;
    mesh_.ring(c.h, mesh_.kinds[c.to] > mesh_.kinds[c.from] ? c.to : c.from, ring_);
    return keeps_sides(c.position);
}

void Simplifier::collapse(const Candidate& c) {
    quadrics_[ring_.keep] += quadrics_[ring_.remove];
    mesh_.collapse(ring_, c.position);
    ++version_[ring_.keep], ++version_[ring_.remove];
    push_around(ring_.keep);
}

void Simplifier::simplify(std::size_t faces) {
    while (!queue_.empty() && mesh_.live_faces() > faces) {
        std::pop_heap(queue_.begin(), queue_.end());
        const Candidate c = queue_.back();
        queue_.pop_back();
        if (is_current(c) && may_collapse(c)) collapse(c);
    }
}

/// Of a face that a collapse removes: whether one of the two faces that come together there has its material.
bool Simplifier::has_material_beside(std::uint32_t h) const {
    if (input_.materials.empty()) return true;
    const std::uint32_t label = input_.materials[h / 3];
    for (const std::uint32_t side : {CollapseMesh::next(h), CollapseMesh::prev(h)})
        if (const std::uint32_t twin = mesh_.twin(side); twin != kNone && input_.materials[twin / 3] == label)
            return true;
    return false;
}

std::vector<Collapse> Simplifier::simplify_round(std::size_t most, std::size_t most_valence) {
    std::vector<Collapse> done;
    std::vector<Candidate> later;
    std::vector<std::uint8_t> is_kept(mesh_.positions.size(), 0);
    std::size_t looked_at = 0;
    while (!queue_.empty() && done.size() < most && looked_at < kPatience * most) {
        std::pop_heap(queue_.begin(), queue_.end());
        const Candidate c = queue_.back();
        queue_.pop_back();
        if (!is_current(c) || !may_collapse(c)) continue;
        ++looked_at;
        const auto kept = [&](std::uint32_t v) { return is_kept[v] != 0; };
        if (kept(c.from) || kept(c.to) || std::ranges::any_of(ring_.vertices, kept)) {
            later.push_back(c);
            continue;
        }
        const std::uint32_t twin = mesh_.twin(c.h);
        if (ring_.faces.size() > most_valence || !has_material_beside(c.h)) continue;
        if (twin != kNone && !has_material_beside(twin)) continue;
        const auto material = [&](std::uint32_t h) { return input_.materials.empty() ? 0 : input_.materials[h / 3]; };
        const auto apex = [&](std::uint32_t h) { return mesh_.from(CollapseMesh::prev(h)); };
        done.push_back({ring_.keep,
                        ring_.remove,
                        {mesh_.positions[ring_.keep], mesh_.positions[ring_.remove]},
                        c.position,
                        c.from,
                        c.to,
                        apex(c.h),
                        twin == kNone ? kNone : apex(twin),
                        {mesh_.on_boundary(c.from), mesh_.on_boundary(c.to)},
                        {material(c.h), twin == kNone ? 0 : material(twin)}});
        is_kept[ring_.keep] = 1;
        collapse(c);
    }
    for (const Candidate& c : later) {
        queue_.push_back(c);
        std::push_heap(queue_.begin(), queue_.end());
    }
    return done;
}

Mesh Simplifier::mesh(std::vector<std::uint32_t>* numbers) const {
    Mesh out;
    std::vector<std::uint32_t> index(mesh_.positions.size(), kNone);
    for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f) {
        if (mesh_.faces[f][0] == kNone) continue;
        Face face = mesh_.faces[f];
        for (std::uint32_t& v : face) {
            if (index[v] == kNone) {
                index[v] = static_cast<std::uint32_t>(out.positions.size());
                out.positions.push_back(mesh_.positions[v]);
                if (numbers) numbers->push_back(v);
            }
            v = index[v];
        }
        out.faces.push_back(face);
        if (!input_.materials.empty()) out.materials.push_back(input_.materials[f]);
    }
    return out;
}

}  // namespace mvw
