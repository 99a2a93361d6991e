// A mesh as a graphics card takes it: one record for each corner of each triangle.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

struct Corner {
    Vec3f position;  // relative to an origin, in units of `scale`
    Vec3f normal;    // unit; zero where all triangles around it are without area
    Rgba8 color;
};

/// 3 F corners. Smooth normals average, weighted by area, the triangles around the vertex that lean less than 40
/// degrees from the corner's own; flat ones are the triangle's. Uncoloured vertices get `plain`. O(V + F).
std::vector<Corner> make_corners(const Mesh& mesh, const Vec3& origin, double scale, bool flat, const Rgba8& plain);

}  // namespace mvw
