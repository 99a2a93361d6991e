// Makes any face soup a manifold, consistently oriented triangle mesh, and counts every action.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// How often each repair was done; all zero for a mesh that was clean.
struct CleanReport {
    std::uint64_t triangulated_polygons = 0;  // filled by the importers
    std::uint64_t welded_vertices = 0;        // bit-equal positions merged
    std::uint64_t unused_vertices = 0;        // in no face
    std::uint64_t degenerate_faces = 0;       // repeated vertex after welding, dropped
    std::uint64_t duplicate_faces = 0;        // same three vertices, dropped
    std::uint64_t split_edges = 0;            // non-manifold edges taken apart
    std::uint64_t split_vertices = 0;         // non-manifold vertices taken apart
    std::uint64_t turned_faces = 0;           // reversed so that neighbours agree
    std::uint64_t cut_edges = 0;              // edges opened because a component cannot be oriented
};

/// Welds, drops degenerate and duplicate faces, splits non-manifold edges and vertices, orients each component
/// (majority of its faces keeps its turn), cuts what cannot be oriented. The result is an oriented manifold, possibly
/// with boundary; its vertices are all used. Deterministic. O(F log F) at most.
Mesh clean(Mesh mesh, CleanReport& report);

/// Topology of one connected component.
struct Component {
    std::uint32_t vertices = 0, edges = 0, faces = 0, boundary_loops = 0;
    int genus = 0;  // (2 - boundary_loops - (V - E + F)) / 2
};
/// Component number of each face (0-based, in order of first face), and the components' topology. Clean meshes only.
std::vector<Component> components(const Mesh& mesh, std::vector<std::uint32_t>& component_of_face);

}  // namespace mvw
