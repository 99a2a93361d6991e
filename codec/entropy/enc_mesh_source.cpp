#include "codec/entropy/enc_mesh_source.h"

#include <algorithm>

namespace mvw {

MeshSource::MeshSource(const BaseMesh& mesh, const std::vector<GridPoint>& grid, std::uint32_t first_face)
    : mesh_(mesh),
      grid_(grid),
      next_start_(first_face),
      has_boundary_(
          std::any_of(mesh.edges().begin(), mesh.edges().end(), [](const BaseEdge& e) { return e.face[1] == kNone; })),
      taken_(mesh.face_count(), 0),
      seen_(mesh.vertex_count(), 0),
      last_node_(mesh.vertex_count(), kNoNode) {}

BeyondGate MeshSource::beyond(const MeshGrowth& growth, std::uint32_t gate) {
    list_nodes(growth);
    const Side there = across(growth, gate);
    if (there.face == kNone) return {};
    const std::uint32_t third = corner(there, 2);
    if (seen_[third] == 0) {
        take(there);
        add_vertex(third);
        return {BeyondGate::Vertex, 0};
    }
    const std::uint32_t end = growth.next(gate);
    const bool after = source_of(growth, growth.next(end)) == third && growth.can_fill(end);
    const bool before = source_of(growth, growth.previous(gate)) == third && growth.can_fill(gate);
    const std::uint32_t other = after || before ? 0 : node_of(growth, there);
    take(there);
    if (after) return {BeyondGate::FillAfter, 0};
    if (before) return {BeyondGate::FillBefore, 0};
    return {BeyondGate::Join, other};
}

const GridPoint& MeshSource::position(std::uint32_t vertex) {
    if (vertex >= origin_.vertex.size()) begin_component();
    return grid_[origin_.vertex[vertex]];
}

void MeshSource::take(const Side& s) {
    taken_[s.face] = 1;
    origin_.face.push_back(s.face);
    origin_.corner.push_back(static_cast<std::uint8_t>(s.side));
}

void MeshSource::add_vertex(std::uint32_t v) {
    seen_[v] = 1;
    origin_.vertex.push_back(v);
}

void MeshSource::begin_component() {
    while (taken_[next_start_] != 0) next_start_ = (next_start_ + 1) % mesh_.face_count();
    const Side s{next_start_, 0};
    take(s);
    for (unsigned k = 0; k < 3; ++k) add_vertex(corner(s, k));
}

/// The source's side beyond a node's edge: it runs as the edge does.
MeshSource::Side MeshSource::across(const MeshGrowth& growth, std::uint32_t node) const {
    const std::uint32_t face = growth.node(node).face, end = growth.node(growth.next(node)).vertex;
    const Face& corners = growth.faces()[face];
    unsigned k = 0;
    while (corners[k] != end) ++k;
    return other_side({origin_.face[face], (origin_.corner[face] + k) % 3});
}

/// The node at whose gap the third corner of a triangle beyond a gate lies. Found by turning around that vertex, away
/// from the gate, to the first triangle that is taken; where a boundary comes before, the other way.
std::uint32_t MeshSource::node_of(const MeshGrowth& growth, const Side& triangle) const {
    const std::uint32_t w = corner(triangle, 2);
    for (Side s{triangle.face, (triangle.side + 2) % 3};; s.side = (s.side + 1) % 3) {  // from w outwards
        const std::uint32_t to = corner(s, 1);
        s = other_side(s);
        if (s.face == kNone) break;
        if (taken_[s.face] != 0) return node_with_edge(growth, w, to);
    }
    for (Side s{triangle.face, (triangle.side + 1) % 3};; s.side = (s.side + 2) % 3) {  // towards w
        const std::uint32_t from = corner(s, 0);
        s = other_side(s);
        if (s.face == kNone) return kNoNode;
        if (taken_[s.face] == 0) continue;
        const std::uint32_t n = node_with_edge(growth, from, w);
        return n == kNoNode ? kNoNode : growth.next(n);
    }
}

std::uint32_t MeshSource::node_with_edge(const MeshGrowth& growth, std::uint32_t from, std::uint32_t to) const {
    for (std::uint32_t n = last_node_[from]; n != kNoNode; n = older_[n])
        if (growth.node(n).alive && source_of(growth, growth.next(n)) == to) return n;
    return kNoNode;
}

void MeshSource::list_nodes(const MeshGrowth& growth) {
    for (auto n = static_cast<std::uint32_t>(older_.size()); n < growth.nodes().size(); ++n) {
        std::uint32_t& last = last_node_[source_of(growth, n)];
        older_.push_back(last);
        last = n;
    }
}

}  // namespace mvw
