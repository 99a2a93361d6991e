// How much of a surface's back is seen from outside.
#pragma once
#include <cstdint>

#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw::bench {

/// Pixels that show backs of faces, in eight pictures of 1500 x 900 each (yaw 0, 90, 180, 270, pitch 20, 60; 10.8
/// million pixels in all): folds, faces turned over and sheets that pass through each other; of an open surface its
/// inside, too.
struct BackPixels {
    std::uint64_t in_place = 0;  // where what lies nearest is drawn, whatever it is: a fault of the mesh
    std::uint64_t seen = 0;      // as pictures are drawn (client/viewer/sides.h): a fault that shows
};

/// Fails as draw_picture() does.
Result<BackPixels> count_backs(const Mesh& mesh);

}  // namespace mvw::bench
