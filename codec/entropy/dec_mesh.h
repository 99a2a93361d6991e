// Decodes a mesh on a grid that enc_mesh.h wrote.
#pragma once
#include <vector>

#include "codec/bytes.h"
#include "codec/entropy/mesh_model.h"
#include "codec/result.h"

namespace mvw {

/// A mesh whose vertices lie on an integer grid.
struct GridMesh {
    std::vector<Face> faces;
    std::vector<GridPoint> grid;
};

/// Coordinates are within 2^bits of zero. Malformed where the bytes make no mesh of these counts. Whether it is a
/// manifold is the caller's to check: indices are in range. Memory is in proportion to the counts, which the caller has
/// held against limits. O(vertices + faces).
Result<GridMesh> decode_mesh(ByteSpan bytes, std::uint32_t vertices, std::uint32_t faces, bool has_boundary,
                             unsigned bits);

}  // namespace mvw
