// The triangles around each vertex, and the order in which vertices may move side by side.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// One triangle around a vertex: its corners behind the vertex, counter-clockwise, and its number.
struct RingTriangle {
    std::uint32_t first = 0, second = 0, triangle = 0;
};

/// The triangles around all vertices of a mesh.
class Rings {
 public:
    Rings(const std::vector<Face>& triangles, std::size_t vertices);

    [[nodiscard]] std::span<const RingTriangle> at(std::uint32_t v) const {
        return std::span(triangles_).subspan(begin_[v], begin_[v + 1] - begin_[v]);
    }

    /// Groups of the vertices that are not `fixed` (V), no two of a group neighbours: the members of one may move at
    /// the same time, and the outcome does not depend on the thread count. O(V).
    [[nodiscard]] std::vector<std::vector<std::uint32_t>> independent_groups(
        const std::vector<std::uint8_t>& fixed) const;

 private:
    std::vector<std::uint32_t> begin_;  // V + 1
    std::vector<RingTriangle> triangles_;
};

}  // namespace mvw
