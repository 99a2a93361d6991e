// How much of a surface's back is seen from outside.
#pragma once
#include <cstdint>

#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw::bench {

/// Pixels that show backs of faces, in eight pictures of 1500 x 900 each (yaw 0, 90, 180, 270, pitch 20, 60; 10.8
/// million pixels in all): folds, faces turned over and sheets that pass through each other, as far as they are seen;
/// of an open surface its inside, too. Fails as draw_picture() does.
Result<std::uint64_t> count_backs(const Mesh& mesh);

}  // namespace mvw::bench
