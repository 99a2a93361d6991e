// Small changes to a clean mesh that leave its surface as it is and let every edge be collapsed.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// A mesh whose faces come in runs, each run covering one face of another mesh.
struct SplitMesh {
    Mesh mesh;
    std::vector<std::uint32_t> first_face;  // of each run, in the other mesh's face order
};

/// Splits the edge opposite to each boundary vertex of a single face (an "ear") at its middle: along a boundary a
/// collapse keeps three successive vertices on one straight line of its chart, which an ear's face would not survive.
SplitMesh split_ears(const Mesh& mesh);

}  // namespace mvw
