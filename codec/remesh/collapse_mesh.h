// A triangle mesh that edges are collapsed in: directed half-edges in flat arrays.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// How a vertex may move: Free anywhere, Line along its feature curve or boundary, Corner not at all.
enum class VertexKind : std::uint8_t { Free, Line, Corner };

/// One triangle around a collapsing edge: centre c (one of the edge's ends before, the new vertex after), then two
/// successive vertices of the ring.
struct RingFace {
    std::uint32_t face = 0;
    std::uint8_t slot = 0;    // corner of `face` that holds the centre
    std::uint8_t center = 0;  // 0: the kept end, 1: the removed end (before the collapse)
};

/// The surroundings of an edge (keep, remove). Ring vertex m and m+1 belong to faces[m]; a closed ring has as many
/// vertices as faces, an open one (the edge touches the boundary) one more.
struct EdgeRing {
    std::uint32_t keep = 0, remove = 0;
    std::vector<std::uint32_t> vertices;
    std::vector<RingFace> faces;
    std::vector<std::uint32_t> half_edges;  // of the edge itself: one in each face that the collapse removes (1 or 2)
    std::vector<std::uint32_t> apex;        // ring position of the third vertex of each of those faces
    bool closed = true;
};

/// Half-edge 3f + s runs from corner s of face f to corner s+1.
class CollapseMesh {
 public:
    /// mesh: clean (every directed edge once, one fan a vertex). sharp: empty, or one flag a half-edge.
    CollapseMesh(const Mesh& mesh, const std::vector<std::uint8_t>& sharp);

    std::vector<Face> faces;  // a removed face has kNone in its first corner
    std::vector<Vec3> positions;
    std::vector<VertexKind> kinds;
    /// Makes Line vertices at which their line turns sharply, seen close up and from `reach` away, Corners.
    void pin_sharp_turns(double degrees, double reach);
    [[nodiscard]] std::size_t live_faces() const { return live_faces_; }

    [[nodiscard]] static std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    [[nodiscard]] static std::uint32_t prev(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    [[nodiscard]] std::uint32_t from(std::uint32_t h) const { return faces[h / 3][h % 3]; }
    [[nodiscard]] std::uint32_t to(std::uint32_t h) const { return from(next(h)); }
    [[nodiscard]] std::uint32_t twin(std::uint32_t h) const { return twins_[h]; }
    [[nodiscard]] bool live(std::uint32_t v) const { return out_[v] != kNone; }
    /// An outgoing half-edge; on a boundary the one without a twin, so that turning counter-clockwise meets all.
    [[nodiscard]] std::uint32_t out(std::uint32_t v) const { return out_[v]; }
    /// The next outgoing half-edge counter-clockwise; kNone past the end of a boundary fan.
    [[nodiscard]] std::uint32_t turn(std::uint32_t h) const { return twins_[prev(h)]; }
    [[nodiscard]] bool on_boundary(std::uint32_t v) const { return twins_[out_[v]] == kNone; }
    /// The edge is a feature or a boundary: it may only be collapsed along itself.
    [[nodiscard]] bool is_line(std::uint32_t h) const { return twins_[h] == kNone || sharp_[h] != 0; }
    [[nodiscard]] bool is_sharp(std::uint32_t h) const { return sharp_[h] != 0; }

    /// Calls visit(neighbour) for every vertex joined to v.
    template <typename Visit>
    void for_neighbors(std::uint32_t v, Visit visit) const {
        std::uint32_t h = out_[v];
        do {
            visit(to(h));
            const std::uint32_t in = prev(h);
            h = twins_[in];
            if (h == kNone) visit(from(in));
        } while (h != kNone && h != out_[v]);
    }

    /// True where collapsing half-edge h keeps the surface's topology (link condition) and leaves no boundary vertex
    /// with a single face.
    [[nodiscard]] bool can_collapse(std::uint32_t h);
    /// Fills the ring of h's edge; `keep` is the end whose index survives.
    void ring(std::uint32_t h, std::uint32_t keep, EdgeRing& ring) const;
    /// Collapses the ring's edge: vertex `keep` takes `position`, the edge's faces go.
    void collapse(const EdgeRing& ring, const Vec3& position);

 private:
    [[nodiscard]] std::array<std::uint32_t, 2> line_neighbors(std::uint32_t v) const;
    [[nodiscard]] Vec3 along_line(std::uint32_t v, std::uint32_t first, double reach) const;
    void walk(std::uint32_t start, std::uint32_t stop, bool removed, EdgeRing& ring) const;
    void set_out(std::uint32_t v, std::uint32_t h);
    [[nodiscard]] unsigned fan_size(std::uint32_t v) const;

    std::vector<std::uint32_t> twins_, out_;
    std::vector<std::uint8_t> sharp_;
    std::vector<std::uint32_t> stamp_;  // scratch of can_collapse
    std::uint32_t clock_ = 0;
    std::size_t live_faces_ = 0;
};

}  // namespace mvw
