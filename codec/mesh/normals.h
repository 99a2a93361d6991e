// Normals of vertices, from the triangles around them.
#pragma once
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// Unit normals of all vertices, the mean over their triangles by area; zero where no triangle has an area. Faces name
/// vertices below positions.size(). O(V + F).
std::vector<Vec3> vertex_normals(std::span<const Vec3> positions, std::span<const Face> faces);

}  // namespace mvw
