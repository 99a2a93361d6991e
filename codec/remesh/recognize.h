// Finds subdivision connectivity in a mesh whatever the order of its vertices and faces, so that input which is
// semi-regular already is coded as it is instead of being remeshed (the problem of Taubin, Detecting and Reconstructing
// Subdivision Connectivity, 2002).
#pragma once
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Components of a mesh seen as a base with levels.
struct Recognized {
    BaseMesh base;
    unsigned levels = 0;
    std::vector<std::uint32_t> vertices;   // V(levels): number in the mesh of each vertex, in hierarchical order
    std::vector<std::uint32_t> materials;  // of each base face; empty where the mesh has none
};

struct Recognition {
    std::vector<Recognized> meshes;                // one for all components of one number of levels, the most first
    std::vector<std::uint32_t> mesh_of_component;  // numbered as components() does; kNone: not recognised
};

/// mesh: clean. Each component is taken for quadrisected as often as possible, each base
/// face within one material; those with fewer than `least_levels` (>= 1) are left out. Where several bases have as many
/// levels (only a surface without irregular vertices leaves a choice), one of them. O(F) for each level.
Recognition recognize(const Mesh& mesh, unsigned least_levels);

}  // namespace mvw
