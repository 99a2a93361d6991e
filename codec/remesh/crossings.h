// Which faces of a mesh that is being decimated others would pass through: a tree of boxes that grow with their faces.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/remesh/collapse_mesh.h"

namespace mvw {

/// Whether two triangles without a common corner pass through each other. Touching does not count, nor do triangles in
/// one plane; rounding decides what is close to that.
bool triangles_cross(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

/// Says of a collapse whether it would lead faces through others. Faces that share an edge are not looked after, nor
/// are those around the new vertex among themselves: folds are others' matter.
class Crossings {
 public:
    /// mesh: must outlive this. O(F log F).
    explicit Crossings(const CollapseMesh& mesh);

    /// Whether the triangles of `ring`, with its edge collapsed to `position`, pass through more faces than they do
    /// now. false where too many faces are near by to say. O(log F) and the faces near by.
    [[nodiscard]] bool get_more(const EdgeRing& ring, const Vec3& position);
    /// After mesh.collapse(ring, ...). Lays out a new tree each time that half of the faces are gone: O(log F)
    /// a face.
    void collapsed(const EdgeRing& ring);

 private:
    struct Box {
        Vec3 least, most;
    };
    void lay_out();
    void sort(std::size_t node, std::size_t begin, std::size_t end);
    void widen_to(std::uint32_t face);
    [[nodiscard]] std::array<Vec3, 3> corners(std::uint32_t face) const;
    /// Into near_: the faces outside the ring whose boxes meet this one. false: a crowd, near_ is not complete.
    [[nodiscard]] bool find_near(const EdgeRing& ring, const Box& box);
    /// How many of near_ the triangle of `center` and the mesh's vertices a and b passes through.
    [[nodiscard]] std::size_t count(const Vec3& center, std::uint32_t a, std::uint32_t b) const;

    const CollapseMesh& mesh_;
    std::vector<std::uint32_t> order_;  // live faces when laid out, near ones together
    std::vector<std::uint32_t> place_;  // of each face in order_
    std::vector<Box> boxes_;            // of a binary heap: node k halves into 2 k + 1 and 2 k + 2
    struct Span {
        std::size_t node, begin, end;
    };
    std::vector<Span> stack_;  // scratch
    struct Near {
        std::uint32_t face;
        Box box;
    };
    std::vector<Near> near_;
};

}  // namespace mvw
