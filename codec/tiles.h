// Cuts a base mesh into tiles: connected groups of about equally many faces. Both directions compute the same ones from
// the connectivity alone (FORMAT.md 4.4), so a file says no more than their number.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Tile of each base face, below `tiles`; 1 <= tiles <= face count. Every tile has a face, and is connected where the
/// base is. Integers only. O(F).
std::vector<std::uint16_t> tile_of_faces(const BaseMesh& base, unsigned tiles);

}  // namespace mvw
