// Signs of trouble in a remeshed surface.
#pragma once
#include <cstdint>

#include "codec/mesh/mesh.h"

namespace mvw::bench {

/// Edges whose two triangles lean over 135 degrees from each other: folds, where the input has no such edges. Edges of
/// triangles without area are not counted. mesh: an oriented manifold. O(F log F).
std::uint64_t count_folds(const Mesh& mesh);

/// Topology summed over all components of a clean mesh.
struct Topology {
    std::uint64_t components = 0, boundary_loops = 0;
    std::int64_t genus = 0;
    friend bool operator==(const Topology&, const Topology&) = default;
};
Topology topology_of(const Mesh& mesh);

}  // namespace mvw::bench
