// Small changes to a clean mesh that leave its surface as it is and let every edge be collapsed.
#pragma once
#include "codec/mesh/mesh.h"

namespace mvw {

/// Splits the edge opposite to each boundary vertex of a single face (an "ear") at its middle: along a boundary a
/// collapse keeps three successive vertices on one straight line of its chart, which an ear's face would not survive.
Mesh split_ears(const Mesh& mesh);

}  // namespace mvw
