// Moves a remesh along its surface until a coarse base mesh says it: the wavelet transform's coarse positions come to
// lie on the normals of a base whose vertices are points of a coarse grid. Then only one number for each base vertex,
// its distance along the normal, is left to be coded.
#pragma once
#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"
#include "codec/part_units.h"
#include "codec/transform/transform.h"

namespace mvw {

/// Rounds of: analysis, coarse positions to the nearest points of their normals, tangential details halved, synthesis;
/// every vertex follows along `input` (remesh/drift.h), as far above it as it was; at the end the fit and unfolding.
/// Vertices on boundaries, creases and borders between materials stay. Returns the grid's points, in units of 2^-bits,
/// one for each base vertex.
///
/// input  the surface, in the units of mesh.positions: those of the coder. O(V log F) a round.
PartUnits::Grid snap(const Mesh& input, const TransformOptions& transform, unsigned bits, unsigned threads,
                     SemiRegularMesh& mesh);

}  // namespace mvw
