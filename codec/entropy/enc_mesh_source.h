// What a mesh coder (mesh_coder.h) asks of the mesh that is coded: what lies beyond each gate, and where each new
// vertex is. For the encoder, and for what counts its bits.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/entropy/mesh_coder.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// How a coded mesh comes from its source.
struct MeshOrigin {
    std::vector<std::uint32_t> face;    // the source's, of each face as a decoder will have it, and
    std::vector<std::uint8_t> corner;   // which corner of it became corner 0
    std::vector<std::uint32_t> vertex;  // likewise of vertices
};

class MeshSource {
 public:
    /// first_face: where the coding begins. The others must outlive this.
    MeshSource(const BaseMesh& mesh, const std::vector<GridPoint>& grid, std::uint32_t first_face);

    BeyondGate beyond(const MeshGrowth& growth, std::uint32_t gate);
    const GridPoint& position(std::uint32_t vertex);

    [[nodiscard]] bool has_boundary() const { return has_boundary_; }
    MeshOrigin take_origin() { return std::move(origin_); }

 private:
    using Side = BaseMesh::Side;  // of the source
    [[nodiscard]] std::uint32_t corner(const Side& s, unsigned k) const {
        return mesh_.faces()[s.face][(s.side + k) % 3];
    }
    [[nodiscard]] Side other_side(const Side& s) const { return mesh_.beyond(s.face, s.side); }
    [[nodiscard]] std::uint32_t source_of(const MeshGrowth& growth, std::uint32_t node) const {
        return origin_.vertex[growth.node(node).vertex];
    }
    [[nodiscard]] Side across(const MeshGrowth& growth, std::uint32_t node) const;
    [[nodiscard]] std::uint32_t node_of(const MeshGrowth& growth, const Side& triangle) const;
    [[nodiscard]] std::uint32_t node_with_edge(const MeshGrowth& growth, std::uint32_t from, std::uint32_t to) const;
    void list_nodes(const MeshGrowth& growth);
    void take(const Side& s);
    void add_vertex(std::uint32_t v);
    void begin_component();

    const BaseMesh& mesh_;
    const std::vector<GridPoint>& grid_;
    std::uint32_t next_start_;
    bool has_boundary_;
    std::vector<std::uint8_t> taken_, seen_;        // faces, vertices
    std::vector<std::uint32_t> last_node_, older_;  // by source vertex; by node: nodes of one vertex, newest first
    MeshOrigin origin_;
};

}  // namespace mvw
