// Semi-regular meshes for tests of what lies behind the remesher.
#pragma once
#include "codec/mesh/refine.h"

namespace mvw {

/// Takes up to `levels` levels off a mesh stored level by level in which the children of face k are faces 4k to 4k + 3
/// of the next level, 4k the one in the middle (the sr_*.ply models).
SemiRegularMesh from_level_order(const Mesh& mesh, unsigned levels);

/// A bumpy ball over an octahedron.
SemiRegularMesh bumpy_ball(unsigned levels);

/// All of it as a plain mesh at its finest level.
Mesh plain(const SemiRegularMesh& mesh);

}  // namespace mvw
