// Where the points of one level of a semi-regular mesh lie on another.
#pragma once
#include <vector>

#include "codec/mesh/semi_regular.h"
#include "codec/remesh/self_parameterization.h"

namespace mvw {

/// A point of a base face, on the triangles of `level`: face is the number of one (triangles_at_level()), weight of its
/// corners.
FacePoint on_level(const FacePoint& point, unsigned level);

/// The inverse: a point on a triangle of `level`, on its base face.
FacePoint on_base(const FacePoint& point, unsigned level);

/// values (V(coarse)) of a level's vertices, linearly over its triangles, at those of a finer `level` (V(level)).
std::vector<Vec3> interpolate(const BaseMesh& base, unsigned coarse, const std::vector<Vec3>& values, unsigned level);

}  // namespace mvw
