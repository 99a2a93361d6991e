// How a coded mesh comes into being: triangle by triangle, each along an edge of what is there. Connectivity alone;
// encoder and decoder run this same code. After S. Gumhold, W. Strasser, Real time compression of triangle mesh
// connectivity (1998), and P. Alliez, M. Desbrun, Valence-driven connectivity encoding for 3D meshes (2001).
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

inline constexpr std::uint32_t kNoNode = 0xFFFFFFFFu;

/// Triangles so far, and their border: rings of nodes. A node is a vertex seen from one gap between triangles (a vertex
/// at which the border touches itself has several) with the edge to the next node of the ring. A gate is such an edge
/// beyond which it is not known yet whether there is a triangle. The triangle beyond a gate from a to b is (a, b, c).
class MeshGrowth {
 public:
    struct Node {
        std::uint32_t vertex, next, previous;
        std::uint32_t face = 0;  // the triangle at its edge
        bool closed = false;     // its edge is a boundary of the mesh
        bool alive = true;
    };

    [[nodiscard]] const std::vector<Face>& faces() const { return faces_; }
    std::vector<Face> take_faces() { return std::move(faces_); }
    [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
    [[nodiscard]] const Node& node(std::uint32_t n) const { return nodes_[n]; }
    [[nodiscard]] std::uint32_t next(std::uint32_t n) const { return nodes_[n].next; }
    [[nodiscard]] std::uint32_t previous(std::uint32_t n) const { return nodes_[n].previous; }
    /// Third vertex of the triangle at a node's edge.
    [[nodiscard]] std::uint32_t inner(std::uint32_t n) const;
    [[nodiscard]] std::uint32_t vertex_count() const { return vertices_; }
    /// Triangles at a vertex.
    [[nodiscard]] unsigned valence(std::uint32_t vertex) const { return valence_[vertex]; }

    /// A triangle of three new vertices, with a ring of its own.
    void start();
    /// The node whose edge is the next gate; false where there is none. Gates around the oldest node come first.
    bool next_gate(std::uint32_t& gate);

    /// Beyond the gate lies nothing.
    void close(std::uint32_t gate);
    /// Beyond it lies a triangle with a new vertex.
    void add_vertex(std::uint32_t gate);
    /// One that fills the gap at the gate's end; needs can_fill(next(gate)).
    void fill_after(std::uint32_t gate);
    /// One that fills the gap at the gate's beginning; needs can_fill(gate).
    void fill_before(std::uint32_t gate);
    /// One to another node, which must be alive; splits a ring, or joins two.
    void join(std::uint32_t gate, std::uint32_t other);

    /// Whether a triangle may fill the gap at a node: both edges there are gates, of three vertices.
    [[nodiscard]] bool can_fill(std::uint32_t n) const;

 private:
    std::uint32_t add_node(std::uint32_t vertex);
    void link(std::uint32_t from, std::uint32_t to);
    /// Returns its number.
    std::uint32_t add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    /// Removes a ring of two nodes, whose edges have become one.
    void drop_pair(std::uint32_t n);

    std::vector<Face> faces_;
    std::vector<Node> nodes_;
    std::vector<std::uint16_t> valence_;
    std::vector<std::uint32_t> waiting_;  // nodes, oldest first
    std::size_t first_waiting_ = 0;
    std::uint32_t vertices_ = 0;
};

}  // namespace mvw
