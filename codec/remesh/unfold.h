// Smooths away the folds that a remesh has where its triangles are too large for what the surface does there: threads
// of a screw, the gap between two fingers. A fold is seen, what it stands for is too small to be.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// Draws vertices at edges whose two triangles lean over 120 degrees from each other towards their neighbours' mean,
/// until no such edge is left, for a few dozen rounds. Vertices flagged `fixed` (V), and edges between two of them,
/// stay; no vertex goes farther than its edges are long. O(F) a round.
void unfold(const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed, std::vector<Vec3>& positions);

}  // namespace mvw
