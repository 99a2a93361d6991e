// Encodes a mesh on a grid; dec_mesh.h reads it.
#pragma once
#include "codec/bytes.h"
#include "codec/entropy/enc_mesh_source.h"

namespace mvw {

struct EncodedMesh {
    Bytes bytes;
    MeshOrigin origin;
};

/// grid: the mesh's vertices, each coordinate within 2^bits of zero; bits at most kMaxMeshBits. Of some beginnings the
/// one that takes fewest bytes is chosen. Empty bytes where the mesh cannot be coded so: it has a vertex without faces,
/// or one at which two surfaces touch. O(V + F) where valences are small.
EncodedMesh encode_mesh(const BaseMesh& mesh, const std::vector<GridPoint>& grid, unsigned bits);

}  // namespace mvw
