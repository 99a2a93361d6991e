// Half-edges of a triangle list by number, grouped by the edge they lie on: what clean() and the topology checks share.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// Half-edge 3f + s runs from corner s to corner s + 1 (mod 3) of face f; it is also the number of that corner.
constexpr std::uint32_t next_half_edge(std::uint32_t h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
constexpr std::uint32_t previous_half_edge(std::uint32_t h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}
inline std::uint32_t origin(std::span<const Face> faces, std::uint32_t h) {
    return faces[h / 3][h % 3];
}

/// Half-edges in groups that join the same two vertices in either direction.
struct EdgeGroups {
    std::vector<std::uint32_t> half_edges;  // group by group, rising within a group
    std::vector<std::uint32_t> starts;      // group g is [starts[g], starts[g+1])

    [[nodiscard]] std::size_t size() const { return starts.size() - 1; }
    [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t g) const {
        return std::span(half_edges).subspan(starts[g], starts[g + 1] - starts[g]);
    }
};

/// Groups all half-edges of the faces, or those h with use[h] != 0 where `use` is not empty (then of size 3F). Groups
/// are in order of their lower, then their higher vertex. O(V + F) but for sorting the edges at a vertex.
EdgeGroups group_edges(std::span<const Face> faces, std::uint32_t vertex_count, std::span<const std::uint8_t> use = {});

/// Vertex of each corner when only the sides joined by `mates` (3F, kNone where open; joined sides run against each
/// other) hold faces together: corners of one fan of faces get one number. Numbers are in order of first corner.
struct Fans {
    std::vector<std::uint32_t> of_corner;  // 3F
    std::uint32_t count = 0;
};
Fans find_fans(std::span<const std::uint32_t> mates);

}  // namespace mvw
