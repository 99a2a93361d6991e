#include "codec/remesh/facets.h"

#include <numeric>

#include "codec/remesh/resample.h"

namespace mvw {

namespace {

constexpr std::size_t kMostTogether = 16'384;  // faces of all such components
constexpr std::uint32_t kFewEars = 4;          // vertices for each one of a single face, at least

/// What of a component decides.
struct Counts {
    std::uint32_t faces = 0, vertices = 0, ears = 0;
};

std::vector<Counts> count(const Mesh& mesh, const std::vector<std::uint32_t>& component_of_face,
                          std::size_t components) {
    std::vector<Counts> counts(components);
    std::vector<std::uint32_t> faces_at(mesh.positions.size(), 0), component_of(mesh.positions.size(), 0);
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        ++counts[component_of_face[f]].faces;
        for (const std::uint32_t v : mesh.faces[f]) ++faces_at[v], component_of[v] = component_of_face[f];
    }
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        if (faces_at[v] == 0) continue;
        ++counts[component_of[v]].vertices;
        if (faces_at[v] == 1) ++counts[component_of[v]].ears;
    }
    return counts;
}

}  // namespace

std::vector<std::uint8_t> choose_facets(const Mesh& mesh, const std::vector<std::uint32_t>& component_of_face,
                                        std::size_t components, const std::function<bool(std::uint32_t)>& wanted) {
    const std::vector<Counts> counts = count(mesh, component_of_face, components);
    std::vector<std::uint8_t> chosen(components, 0);
    std::size_t together = 0;
    for (std::uint32_t c = 0; c < components; ++c) {
        if (!wanted(c) || counts[c].faces > kMostFacets || counts[c].ears * kFewEars >= counts[c].vertices) continue;
        chosen[c] = 1;
        together += counts[c].faces;
    }
    if (together > kMostTogether) chosen.assign(components, 0);
    return chosen;
}

SemiRegularMesh facets_of(const Mesh& mesh) {
    SemiRegularMesh part;
    part.base = BaseMesh::create(static_cast<std::uint32_t>(mesh.positions.size()), mesh.faces).value();
    part.levels = 1;
    part.creases.assign(part.base.edge_count(), 1);  // boundaries, too: all the same cost next to nothing
    part.materials = mesh.materials;
    std::vector<std::uint32_t> same(mesh.faces.size());
    std::iota(same.begin(), same.end(), 0u);
    const std::vector<FacePoint> points = grid_points(part.base, part.levels, same);
    part.positions = positions_of(mesh, points);
    take_vertex_data(mesh, points, part);
    return part;
}

}  // namespace mvw
