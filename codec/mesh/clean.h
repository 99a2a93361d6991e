// Makes any face soup a manifold, consistently oriented triangle mesh, and counts every action.
//
// The idea (cf. [GTLH01] Gueziec, Taubin, Lazarus & Horn, Cutting and Stitching: Converting Sets of Polygons to
// Manifold Surfaces): decide for each side of each face which one other side it is sewn to, then let every chain of
// faces sewn around a corner be one vertex. Vertices that pinch the surface come apart by construction.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// How often each repair was done; all zero for a mesh that was clean.
struct CleanReport {
    std::uint64_t triangulated_polygons = 0;    // filled by the importers
    std::uint64_t replaced_values = 0;          // likewise: numbers of fields that were none, now the field's mean
    std::vector<std::string> dropped_fields;    // likewise: names of what files say of vertices that is not kept
    std::uint64_t textured_vertices = 0;        // likewise: of meshes some of whose materials have images
    std::vector<std::string> missing_textures;  // likewise: images that could not be read, and why
    std::uint64_t welded_vertices = 0;          // joined with another of bit-equal position
    std::uint64_t unused_vertices = 0;          // in no face
    std::uint64_t degenerate_faces = 0;  // repeated vertex after welding, or a vertex that is not finite: dropped
    std::uint64_t duplicate_faces = 0;   // same three vertices, in any order: dropped
    std::uint64_t split_edges = 0;       // non-manifold edges taken apart
    std::uint64_t split_vertices = 0;    // copies made to take non-manifold vertices, edges and cuts apart
    std::uint64_t turned_faces = 0;      // reversed so that neighbours agree
    std::uint64_t cut_edges = 0;         // edges opened because a component cannot be oriented
};

/// Welds, drops degenerate and duplicate faces, splits non-manifold edges and vertices, orients each component
/// (majority of its faces keeps its turn), cuts what cannot be oriented, if it can where the input turns over. The
/// result is an oriented manifold, possibly with boundary: is_clean_manifold() holds. Vertices and faces keep their
/// order: a clean mesh of distinct positions comes back unchanged.
///
/// Welding sews sides of faces that lie at bit-equal positions. Where the indices already close the surface around a
/// vertex they are believed: two such vertices at one position stay two, and faces that are flat between them stay.
/// At an edge of many faces those are joined that bound one solid wedge, so closed parts that touch stay closed parts.
/// A welded vertex takes the mean colour and fields of those it joins. Deterministic; close to linear time.
Mesh clean(Mesh mesh, CleanReport& report);

/// True where each directed edge is used once, the faces around each vertex form one fan, every vertex is used, all
/// positions are finite and attributes are of the right size. Otherwise `why` (if given) says what is wrong. O(F).
bool is_clean_manifold(const Mesh& mesh, std::string* why = nullptr);

/// Topology of one connected component.
struct Component {
    std::uint32_t vertices = 0, edges = 0, faces = 0, boundary_loops = 0;
    int genus = 0;  // (2 - boundary_loops - (V - E + F)) / 2
};
/// Component number of each face (0-based, in order of first face), and the components' topology. Clean meshes only.
std::vector<Component> components(const Mesh& mesh, std::vector<std::uint32_t>& component_of_face);

}  // namespace mvw
