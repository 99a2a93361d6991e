// Lays the regular grid of a semi-regular mesh over a base and looks up where its points are on the input.
#pragma once
#include <vector>

#include "codec/mesh/semi_regular.h"
#include "codec/remesh/self_parameterization.h"

namespace mvw {

/// The dyadic points of all base faces at `level`, in hierarchical order. face_ids: for each base face the number that
/// FacePoint::face shall have (its corner order must agree with the base's).
std::vector<FacePoint> grid_points(const BaseMesh& base, unsigned level, const std::vector<std::uint32_t>& face_ids);

/// Their places in space.
std::vector<Vec3> positions_of(const Mesh& mesh, const std::vector<FacePoint>& points);

/// Gives `to` their colours and fields, between those of the mesh's vertices; none where it has none.
void take_vertex_data(const Mesh& mesh, const std::vector<FacePoint>& points, SemiRegularMesh& to);

}  // namespace mvw
