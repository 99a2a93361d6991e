#include "codec/remesh/collapse_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace mvw {

namespace {

/// Twin of every half-edge, by sorting undirected edges.
std::vector<std::uint32_t> pair_half_edges(const std::vector<Face>& faces) {
    struct Key {
        std::uint64_t edge;
        std::uint32_t half_edge;
    };
    std::vector<Key> keys;
    keys.reserve(faces.size() * 3);
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        for (std::uint32_t s = 0; s < 3; ++s) {
            const std::uint32_t a = faces[f][s], b = faces[f][(s + 1) % 3];
            keys.push_back({(std::uint64_t{std::min(a, b)} << 32) | std::max(a, b), 3 * f + s});
        }
    }
    std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
        return a.edge != b.edge ? a.edge < b.edge : a.half_edge < b.half_edge;
    });
    std::vector<std::uint32_t> twins(keys.size(), kNone);
    for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
        if (keys[k].edge != keys[k + 1].edge) continue;
        twins[keys[k].half_edge] = keys[k + 1].half_edge;
        twins[keys[k + 1].half_edge] = keys[k].half_edge;
    }
    return twins;
}

}  // namespace

CollapseMesh::CollapseMesh(const Mesh& mesh, const std::vector<std::uint8_t>& sharp)
    : faces(mesh.faces),
      positions(mesh.positions),
      kinds(mesh.positions.size(), VertexKind::Free),
      twins_(pair_half_edges(mesh.faces)),
      out_(mesh.positions.size(), kNone),
      sharp_(sharp.empty() ? std::vector<std::uint8_t>(mesh.faces.size() * 3, 0) : sharp),
      stamp_(mesh.positions.size(), 0),
      live_faces_(mesh.faces.size()) {
    for (std::uint32_t h = 0; h < twins_.size(); ++h)
        if (out_[from(h)] == kNone || twins_[h] == kNone) out_[from(h)] = h;
    std::vector<std::uint8_t> lines(positions.size(), 0);
    for (std::uint32_t h = 0; h < twins_.size(); ++h) {
        if (!is_line(h) || (twins_[h] != kNone && twins_[h] < h)) continue;
        for (const std::uint32_t v : {from(h), to(h)})
            if (lines[v] < 3) ++lines[v];
    }
    for (std::size_t v = 0; v < kinds.size(); ++v)
        kinds[v] = lines[v] == 0 ? VertexKind::Free : lines[v] == 2 ? VertexKind::Line : VertexKind::Corner;
}

std::array<std::uint32_t, 2> CollapseMesh::line_neighbors(std::uint32_t v) const {
    std::array<std::uint32_t, 2> ends{kNone, kNone};
    std::size_t count = 0;
    std::uint32_t h = out_[v];
    do {
        if (is_line(h) && count < 2) ends[count++] = to(h);
        const std::uint32_t in = prev(h);
        h = twins_[in];
        if (h == kNone && count < 2) ends[count++] = from(in);
    } while (h != kNone && h != out_[v]);
    return ends;
}

/// The point of the line through v that is `reach` away in direction of its neighbour `first`, or the line's end.
Vec3 CollapseMesh::along_line(std::uint32_t v, std::uint32_t first, double reach) const {
    std::uint32_t last = v, at = first;
    double left = reach - length(positions[at] - positions[v]);
    while (left > 0 && kinds[at] == VertexKind::Line && at != v) {
        const std::array<std::uint32_t, 2> ends = line_neighbors(at);
        const std::uint32_t next_vertex = ends[0] == last ? ends[1] : ends[0];
        if (next_vertex == kNone) break;
        last = at, at = next_vertex;
        left -= length(positions[at] - positions[last]);
    }
    return positions[at];
}

void CollapseMesh::pin_sharp_turns(double degrees, double reach) {
    const double cosine = std::cos(degrees * std::numbers::pi / 180);
    const auto turns = [&](const Vec3& a, const Vec3& v, const Vec3& b) {
        const Vec3 in = v - a, out = b - v;
        return dot(in, out) < cosine * length(in) * length(out);
    };
    std::vector<std::uint32_t> pinned;
    for (std::uint32_t v = 0; v < kinds.size(); ++v) {
        if (kinds[v] != VertexKind::Line) continue;
        const auto [a, b] = line_neighbors(v);
        if (a == kNone || b == kNone || !turns(positions[a], positions[v], positions[b])) continue;
        // The jagged edge of a scan turns at every vertex, but not from further away.
        if (turns(along_line(v, a, reach), positions[v], along_line(v, b, reach))) pinned.push_back(v);
    }
    for (const std::uint32_t v : pinned) kinds[v] = VertexKind::Corner;
}

unsigned CollapseMesh::fan_size(std::uint32_t v) const {
    unsigned n = 0;
    std::uint32_t h = out_[v];
    do {
        ++n;
        h = turn(h);
    } while (h != kNone && h != out_[v]);
    return n;
}

bool CollapseMesh::can_collapse(std::uint32_t h) {
    const std::uint32_t i = from(h), j = to(h);
    const bool boundary_edge = twins_[h] == kNone;
    if (!boundary_edge && on_boundary(i) && on_boundary(j)) return false;
    ++clock_;
    for_neighbors(i, [&](std::uint32_t v) { stamp_[v] = clock_; });
    unsigned common = 0;
    for_neighbors(j, [&](std::uint32_t v) { common += stamp_[v] == clock_ ? 1 : 0; });
    if (common != (boundary_edge ? 1u : 2u)) return false;
    for (const std::uint32_t side : {h, twins_[h]}) {
        if (side == kNone) continue;
        const std::uint32_t tip = from(prev(side));
        if (fan_size(tip) < (on_boundary(tip) ? 3u : 4u)) return false;
    }
    // The new vertex keeps the faces of both ends less those of the edge.
    const unsigned left = fan_size(i) + fan_size(j) - (boundary_edge ? 2 : 4);
    return left >= (on_boundary(i) || on_boundary(j) ? 2u : 3u);
}

void CollapseMesh::walk(std::uint32_t start, std::uint32_t stop, bool removed, EdgeRing& ring) const {
    std::uint32_t last = kNone;
    for (std::uint32_t h = start; h != stop; h = turn(h)) {
        ring.vertices.push_back(to(h));
        ring.faces.push_back({h / 3, static_cast<std::uint8_t>(h % 3), static_cast<std::uint8_t>(removed)});
        last = h;
    }
    if (stop == kNone && last != kNone) ring.vertices.push_back(from(prev(last)));
}

void CollapseMesh::ring(std::uint32_t h, std::uint32_t keep, EdgeRing& ring) const {
    ring.keep = keep;
    ring.remove = from(h) == keep ? to(h) : from(h);
    ring.vertices.clear(), ring.faces.clear(), ring.half_edges.clear(), ring.apex.clear();
    const auto add_edge_face = [&](std::uint32_t half_edge) {
        ring.half_edges.push_back(half_edge);
        ring.apex.push_back(static_cast<std::uint32_t>(ring.vertices.size()));
    };
    ring.closed = !on_boundary(from(h)) && !on_boundary(to(h));
    std::uint32_t g = twins_[h];
    if (!ring.closed && g != kNone && on_boundary(to(h))) std::swap(h, g);  // the boundary end first
    const bool first = from(h) == ring.remove;
    if (g == kNone) {  // a boundary edge: around its far end up to the edge's face, then around its near end
        walk(out_[to(h)], next(h), !first, ring);
        add_edge_face(h);
    } else {
        if (!ring.closed) walk(out_[from(h)], next(g), first, ring);
        if (!ring.closed) add_edge_face(g);
        if (ring.closed) {  // around from(h), from h's left face to g's
            add_edge_face(h);
            walk(turn(h), next(g), first, ring);
            add_edge_face(g);
            walk(turn(g), next(h), !first, ring);
            return;
        }
        walk(turn(g), next(h), !first, ring);
        add_edge_face(h);
    }
    if (turn(h) == kNone) ring.vertices.push_back(from(prev(h)));
    walk(turn(h), kNone, first, ring);
}

void CollapseMesh::set_out(std::uint32_t v, std::uint32_t h) {
    const std::uint32_t begin = h;
    while (twins_[h] != kNone) {
        h = next(twins_[h]);
        if (h == begin) break;
    }
    out_[v] = h;
}

void CollapseMesh::collapse(const EdgeRing& ring, const Vec3& position) {
    for (const RingFace& r : ring.faces) faces[r.face][r.slot] = ring.keep;
    for (const std::uint32_t h : ring.half_edges) {
        // The edge's face closes like a book: its two other sides become one edge.
        const std::uint32_t a = twins_[next(h)], b = twins_[prev(h)];
        const std::uint8_t sharp = sharp_[next(h)] | sharp_[prev(h)];
        if (a != kNone) twins_[a] = b, sharp_[a] = sharp;
        if (b != kNone) twins_[b] = a, sharp_[b] = sharp;
        faces[h / 3][0] = kNone;
        --live_faces_;
    }
    for (std::size_t k = 0; k < ring.faces.size(); ++k) {
        const std::uint32_t h = ring.faces[k].face * 3 + ring.faces[k].slot;
        set_out(ring.vertices[k], next(h));
        if (k + 1 == ring.faces.size() && !ring.closed) set_out(ring.vertices[k + 1], prev(h));
        if (k == 0) set_out(ring.keep, h);
    }
    kinds[ring.keep] = std::max(kinds[ring.keep], kinds[ring.remove]);
    out_[ring.remove] = kNone;
    positions[ring.keep] = position;
}

}  // namespace mvw
