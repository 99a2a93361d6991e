#include "codec/remesh/crossings.h"

#include <algorithm>

namespace mvw {

namespace {

constexpr std::size_t kLeaf = 4;      // faces, or fewer
constexpr std::size_t kCrowd = 1000;  // faces near by: in such a tangle nothing stays apart, and looking takes long

double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return dot(cross(b - a, c - a), d - a);
}

/// Whether the segment (p, q), whose ends lie on both sides of the triangle's plane, passes through the triangle.
bool pierces(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& t) {
    const double x = volume(p, q, t[0], t[1]), y = volume(p, q, t[1], t[2]), z = volume(p, q, t[2], t[0]);
    return (x > 0 && y > 0 && z > 0) || (x < 0 && y < 0 && z < 0);
}

/// On which side of the triangle's plane another one's corners lie, and how far.
std::array<double, 3> sides(const std::array<Vec3, 3>& triangle, const std::array<Vec3, 3>& other) {
    const Vec3 n = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    return {dot(n, other[0] - triangle[0]), dot(n, other[1] - triangle[0]), dot(n, other[2] - triangle[0])};
}

/// Of triangles that share their corners a[i] and b[k] alone.
bool cross_beyond(const std::array<Vec3, 3>& a, unsigned i, const std::array<Vec3, 3>& b, unsigned k) {
    const auto passes = [](const std::array<Vec3, 3>& t, unsigned corner, const std::array<Vec3, 3>& through) {
        const unsigned from = (corner + 1) % 3, to = (corner + 2) % 3;
        const std::array<double, 3> side = sides(through, t);
        return side[from] * side[to] < 0 && pierces(t[from], t[to], through);
    };
    return passes(a, i, b) || passes(b, k, a);
}

template <class Box>
void widen(Box& box, const Vec3& p) {
    for (std::size_t k = 0; k < 3; ++k)
        box.least[k] = std::min(box.least[k], p[k]), box.most[k] = std::max(box.most[k], p[k]);
}

template <class Box>
bool meet(const Box& a, const Box& b) {
    for (std::size_t k = 0; k < 3; ++k)
        if (a.least[k] > b.most[k] || b.least[k] > a.most[k]) return false;
    return true;
}

template <class Box>
Box box_of(const std::array<Vec3, 3>& triangle) {
    Box box{triangle[0], triangle[0]};
    for (const Vec3& p : triangle) widen(box, p);
    return box;
}

}  // namespace

bool triangles_cross(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
    const std::array<double, 3> of_a = sides(b, a), of_b = sides(a, b);
    const auto apart = [](const std::array<double, 3>& s) {
        return (s[0] > 0 && s[1] > 0 && s[2] > 0) || (s[0] < 0 && s[1] < 0 && s[2] < 0);
    };
    if (apart(of_a) || apart(of_b)) return false;
    for (unsigned i = 0, j = 1; i < 3; ++i, j = (j + 1) % 3) {
        if (of_a[i] * of_a[j] < 0 && pierces(a[i], a[j], b)) return true;
        if (of_b[i] * of_b[j] < 0 && pierces(b[i], b[j], a)) return true;
    }
    return false;
}

Crossings::Crossings(const CollapseMesh& mesh) : mesh_(mesh), place_(mesh.faces.size(), kNone) {
    lay_out();
}

std::array<Vec3, 3> Crossings::corners(std::uint32_t face) const {
    const Face& f = mesh_.faces[face];
    return {mesh_.positions[f[0]], mesh_.positions[f[1]], mesh_.positions[f[2]]};
}

void Crossings::lay_out() {
    order_.clear();
    for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f)
        if (mesh_.faces[f][0] != kNone) order_.push_back(f);
    boxes_.assign(4 * order_.size() / kLeaf + 1, {});
    if (!order_.empty()) sort(0, 0, order_.size());
    for (std::uint32_t k = 0; k < order_.size(); ++k) place_[order_[k]] = k;
}

void Crossings::sort(std::size_t node, std::size_t begin, std::size_t end) {
    Box box = box_of<Box>(corners(order_[begin]));
    for (std::size_t k = begin; k < end; ++k)
        for (const Vec3& p : corners(order_[k])) widen(box, p);
    if (node >= boxes_.size()) boxes_.resize(node + 1);
    boxes_[node] = box;
    if (end - begin <= kLeaf) return;
    const Vec3 extent = box.most - box.least;
    const std::size_t axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto along = [&](std::uint32_t f) {
        const std::array<Vec3, 3> t = corners(f);
        return t[0][axis] + t[1][axis] + t[2][axis];
    };
    const std::size_t middle = (begin + end) / 2;
    const auto at = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t f, std::uint32_t g) {
        const double x = along(f), y = along(g);
        return x != y ? x < y : f < g;
    });
    sort(2 * node + 1, begin, middle);
    sort(2 * node + 2, middle, end);
}

void Crossings::widen_to(std::uint32_t face) {
    const std::array<Vec3, 3> t = corners(face);
    std::size_t node = 0, begin = 0, end = order_.size();
    for (;;) {
        for (const Vec3& p : t) widen(boxes_[node], p);
        if (end - begin <= kLeaf) return;
        const std::size_t middle = (begin + end) / 2;
        const bool left = place_[face] < middle;
        node = 2 * node + (left ? 1 : 2);
        (left ? end : begin) = middle;
    }
}

bool Crossings::find_near(const EdgeRing& ring, const Box& box) {
    near_.clear();
    const auto look_at = [&](std::uint32_t face) {
        const Face& f = mesh_.faces[face];
        const auto in_ring = [&](std::uint32_t v) { return v == ring.keep || v == ring.remove; };
        if (f[0] == kNone || std::ranges::any_of(f, in_ring)) return;
        if (const Box its = box_of<Box>(corners(face)); meet(its, box)) near_.push_back({face, its});
    };
    stack_.assign(1, {0, 0, order_.size()});
    while (!stack_.empty()) {
        const auto [node, begin, end] = stack_.back();
        stack_.pop_back();
        if (!meet(boxes_[node], box)) continue;
        if (end - begin <= kLeaf) {
            for (std::size_t k = begin; k < end; ++k) look_at(order_[k]);
            if (near_.size() > kCrowd) return false;
            continue;
        }
        const std::size_t middle = (begin + end) / 2;
        stack_.push_back({2 * node + 1, begin, middle});
        stack_.push_back({2 * node + 2, middle, end});
    }
    return true;
}

std::size_t Crossings::count(const Vec3& center, std::uint32_t a, std::uint32_t b) const {
    const std::array<Vec3, 3> triangle{center, mesh_.positions[a], mesh_.positions[b]};
    const Box box = box_of<Box>(triangle);
    const auto crosses = [&](const Near& near) {
        if (!meet(near.box, box)) return false;
        const Face& f = mesh_.faces[near.face];
        unsigned shared = 0, mine = 0, its = 0;
        for (unsigned k = 0; k < 3; ++k)
            if (f[k] == a || f[k] == b) ++shared, mine = f[k] == a ? 1 : 2, its = k;
        if (shared == 2) return false;
        const std::array<Vec3, 3> other = corners(near.face);
        return shared == 1 ? cross_beyond(triangle, mine, other, its) : triangles_cross(triangle, other);
    };
    return static_cast<std::size_t>(std::ranges::count_if(near_, crosses));
}

bool Crossings::get_more(const EdgeRing& ring, const Vec3& position) {
    Box box{position, position};
    for (const std::uint32_t v : ring.vertices) widen(box, mesh_.positions[v]);
    if (!find_near(ring, box)) return false;
    const std::size_t n = ring.vertices.size();
    std::size_t after = 0, before = 0;
    for (std::size_t m = 0; m < ring.faces.size(); ++m)
        after += count(position, ring.vertices[m], ring.vertices[(m + 1) % n]);
    if (after == 0) return false;
    widen(box, mesh_.positions[ring.keep]);
    widen(box, mesh_.positions[ring.remove]);
    if (!find_near(ring, box)) return false;
    for (std::size_t m = 0; m < ring.faces.size(); ++m) {
        const Vec3& center = mesh_.positions[ring.faces[m].center == 0 ? ring.keep : ring.remove];
        before += count(center, ring.vertices[m], ring.vertices[(m + 1) % n]);
    }
    return after > before;
}

void Crossings::collapsed(const EdgeRing& ring) {
    if (2 * mesh_.live_faces() < order_.size()) {
        lay_out();
        return;
    }
    for (const RingFace& f : ring.faces) widen_to(f.face);
}

}  // namespace mvw
