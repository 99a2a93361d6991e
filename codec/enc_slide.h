// Slides a remesh along the surface until its details point along the normal: a "normal mesh" (Guskov, Vidimce,
// Sweldens, Schroeder 2000), reached by iteration. Where a vertex lies within the surface tells nothing about the
// shape, so bytes that say it are lost: sliding saves a quarter to a half of them.
#pragma once
#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"
#include "codec/transform/transform.h"

namespace mvw {

/// Rounds of: analysis, tangential details halved, synthesis, and a walk over `input` to where that leads
/// (remesh/drift.h: as far as the triangles stand it). Then the fit (remesh/fit.h), because vertices on the surface are
/// not those that come nearest to it, and the colours of where they have come to rest. Vertices on boundaries, creases
/// and borders between materials slide along these. Left as it was where the result is farther from the input than
/// kMostLoss allows.
///
/// input  clean, in model units; mesh: a part of it. O(V log F) a round.
void slide(const Mesh& input, const TransformOptions& transform, unsigned threads, SemiRegularMesh& mesh);

}  // namespace mvw
