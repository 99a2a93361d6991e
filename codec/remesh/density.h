// How densely a mesh samples its surface: people and scanners put vertices where there is something to see, so a remesh
// does well to follow.
#pragma once
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// For each face the mean area of the faces around it, squared model units; > 0 but for meshes without area. Means over
/// vertices and faces in turn, a few times, so slivers and single small faces do not show. O(F).
std::vector<double> areas_around(const std::vector<Vec3>& positions, const std::vector<Face>& faces);

}  // namespace mvw
