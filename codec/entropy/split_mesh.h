// A triangle mesh whose vertices are split: what the decoder of a progressive mesh grows (Hoppe, Progressive Meshes,
// 1996), and the encoder beside it.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// The faces around a vertex, counter-clockwise: face m has the corners v, neighbor[m], neighbor[m + 1]. A closed ring
/// has as many neighbours as faces, an open one (v lies on a boundary) one more.
struct VertexRing {
    static constexpr std::size_t kMostFaces = 63;
    std::array<std::uint32_t, kMostFaces + 1> neighbor, half_edge;  // half_edge: from v, one of each face
    std::size_t neighbors = 0, faces = 0;
    bool closed = true;
    /// The place of neighbour m, counted round and round.
    [[nodiscard]] std::size_t place(std::size_t m) const { return m % neighbors; }
};

/// What a split does with the ring of v: the new vertex w takes over the faces from `first` on, so many. Two faces come
/// between v and w, at neighbours `first` and `first + taken`; where w is to be on the boundary, one alone, at `first`,
/// and w takes all faces from there to the ring's end.
struct Split {
    std::uint32_t vertex = 0;
    std::uint32_t first = 0, taken = 0;
    bool boundary = false;
    friend bool operator==(const Split&, const Split&) = default;
};

/// Half-edge 3f + s runs from corner s of face f to corner s + 1.
class SplitMesh {
 public:
    /// materials: empty, or one for each face.
    SplitMesh(const BaseMesh& mesh, std::vector<std::uint32_t> materials);

    [[nodiscard]] std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(out_.size()); }
    [[nodiscard]] const std::vector<Face>& faces() const { return faces_; }
    [[nodiscard]] const std::vector<std::uint32_t>& materials() const { return materials_; }

    /// False where it has no faces, or more than VertexRing::kMostFaces, which then are not all there: such a vertex is
    /// not split.
    bool ring(std::uint32_t v, VertexRing& out) const;

    /// Whether the ring allows the split: w has three faces or more within the surface, two neighbours on a boundary,
    /// and so has v.
    [[nodiscard]] static bool is_possible(const VertexRing& ring, const Split& split);
    /// Faces on either side of the edge at which a new face comes: the one that v keeps and the one that w takes over,
    /// kNone where there is none. side 0: at `first`, 1: at `first + taken`.
    [[nodiscard]] static std::pair<std::uint32_t, std::uint32_t> beside(const VertexRing& ring, const Split& split,
                                                                        unsigned side);
    /// ring: of the split's vertex. The new vertex is the last one, the new faces are the last ones, side 0 first;
    /// materials: theirs.
    void split(const VertexRing& ring, const Split& split, const std::array<std::uint32_t, 2>& materials);

 private:
    void join(std::uint32_t h, std::uint32_t twin);
    std::uint32_t add_face(const Face& face, std::uint32_t material);

    std::vector<Face> faces_;
    std::vector<std::uint32_t> materials_;  // empty, or of each face
    std::vector<std::uint32_t> twins_;      // of each half-edge; kNone on a boundary
    std::vector<std::uint32_t> out_;        // a half-edge from each vertex; on a boundary the one without a twin
};

}  // namespace mvw
