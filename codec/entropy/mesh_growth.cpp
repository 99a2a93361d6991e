#include "codec/entropy/mesh_growth.h"

namespace mvw {

std::uint32_t MeshGrowth::add_node(std::uint32_t vertex) {
    const auto n = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({vertex, n, n});
    waiting_.push_back(n);
    return n;
}

void MeshGrowth::link(std::uint32_t from, std::uint32_t to) {
    nodes_[from].next = to;
    nodes_[to].previous = from;
}

std::uint32_t MeshGrowth::add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    faces_.push_back({a, b, c});
    for (const std::uint32_t v : {a, b, c})
        valence_[v] = static_cast<std::uint16_t>(valence_[v] + (valence_[v] < 65535));
    return static_cast<std::uint32_t>(faces_.size() - 1);
}

std::uint32_t MeshGrowth::inner(std::uint32_t n) const {
    const Face& f = faces_[nodes_[n].face];
    return f[0] ^ f[1] ^ f[2] ^ nodes_[n].vertex ^ nodes_[next(n)].vertex;
}

void MeshGrowth::start() {
    const std::uint32_t v = vertices_;
    vertices_ += 3;
    valence_.resize(vertices_, 0);
    const std::uint32_t face = add_face(v, v + 1, v + 2);
    // Beyond an edge the triangle runs the other way, so the ring does, too.
    const std::uint32_t a = add_node(v), c = add_node(v + 2), b = add_node(v + 1);
    link(a, c);
    link(c, b);
    link(b, a);
    for (const std::uint32_t n : {a, b, c}) nodes_[n].face = face;
}

bool MeshGrowth::next_gate(std::uint32_t& gate) {
    for (; first_waiting_ < waiting_.size(); ++first_waiting_) {
        gate = waiting_[first_waiting_];
        if (nodes_[gate].alive && !nodes_[gate].closed) return true;
    }
    return false;
}

void MeshGrowth::close(std::uint32_t gate) {
    nodes_[gate].closed = true;
}

void MeshGrowth::add_vertex(std::uint32_t gate) {
    const std::uint32_t end = next(gate), c = vertices_++;
    valence_.push_back(0);
    const std::uint32_t n = add_node(c);
    nodes_[gate].face = nodes_[n].face = add_face(nodes_[gate].vertex, nodes_[end].vertex, c);
    link(gate, n);
    link(n, end);
}

bool MeshGrowth::can_fill(std::uint32_t n) const {
    const Node& node = nodes_[n];
    const Node& before = nodes_[node.previous];
    const Node& after = nodes_[node.next];
    return !node.closed && !before.closed && before.vertex != node.vertex && before.vertex != after.vertex &&
           node.vertex != after.vertex;
}

void MeshGrowth::drop_pair(std::uint32_t n) {
    const std::uint32_t other = next(n);
    if (next(other) != n || nodes_[n].closed || nodes_[other].closed) return;
    nodes_[n].alive = nodes_[other].alive = false;
}

void MeshGrowth::fill_after(std::uint32_t gate) {
    const std::uint32_t middle = next(gate), end = next(middle);
    nodes_[gate].face = add_face(nodes_[gate].vertex, nodes_[middle].vertex, nodes_[end].vertex);
    nodes_[middle].alive = false;
    link(gate, end);
    drop_pair(gate);
}

void MeshGrowth::fill_before(std::uint32_t gate) {
    const std::uint32_t end = next(gate), before = previous(gate);
    nodes_[before].face = add_face(nodes_[gate].vertex, nodes_[end].vertex, nodes_[before].vertex);
    nodes_[gate].alive = false;
    link(before, end);
    drop_pair(before);
}

void MeshGrowth::join(std::uint32_t gate, std::uint32_t other) {
    const std::uint32_t end = next(gate), after = next(other);
    const std::uint32_t twin = add_node(nodes_[other].vertex);  // takes over the other's edge
    nodes_[twin].face = nodes_[other].face;
    nodes_[twin].closed = nodes_[other].closed;
    nodes_[gate].face = nodes_[other].face = add_face(nodes_[gate].vertex, nodes_[end].vertex, nodes_[other].vertex);
    nodes_[other].closed = false;
    waiting_.push_back(other);
    link(twin, after);
    link(gate, twin);
    link(other, end);
}

}  // namespace mvw
