// Smooths away the folds that a remesh has where its triangles are too large for what the surface does there: threads
// of a screw, the gap between two fingers. A fold is seen, what it stands for is too small to be.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// Draws the corners of triangles that look away from the surface towards their neighbours' mean, for a few dozen
/// rounds at most. normals (V): of the surface where each vertex is, zero where that is not
/// known. Vertices flagged `fixed` (V) stay; none goes
/// farther than its edges are long. O(F) a round.
void unfold(const std::vector<Face>& triangles, const std::vector<Vec3>& normals,
            const std::vector<std::uint8_t>& fixed, std::vector<Vec3>& positions);

}  // namespace mvw
