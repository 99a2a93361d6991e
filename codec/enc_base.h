// Writes a Base chunk, and gives the part the order of faces and vertices that a decoder will find in it.
#pragma once
#include "codec/bytes.h"
#include "codec/dec_base.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Level 0 of a part coded on a grid, and how the decoded mesh maps to the source.
struct CodedBase {
    BaseMethod method = BaseMethod::Grown;
    Bytes bytes;                              // Draco's without the 11 in front
    BaseMesh mesh;                            // as a decoder will have it
    std::vector<GridPoint> grid;              // its vertices' positions on the lattice
    bool progressive = false;                 // splits follow: the counts are not the header's
    std::vector<std::uint32_t> source_face;   // of each decoded face, and
    std::vector<std::uint8_t> source_corner;  // which corner of it became corner 0
};

/// grid: the source's vertices on a lattice of so many bits, below 2^30. alone: whether it is all of a part, which is
/// Draco's; else the way of fewest bytes is taken, mostly our own (entropy/enc_mesh.h). Cannot fail for a valid base:
/// what edgebreaker would change is coded sequentially.
CodedBase code_base(const BaseMesh& source, const std::vector<GridPoint>& grid, unsigned bits, bool alone);

/// A mesh on a grid by Draco, without the 11 bytes in front; empty where it refuses. speed: 0 (best) to 10.
Bytes write_draco(const std::vector<Face>& faces, const std::vector<GridPoint>& grid, bool sequential, int speed);

/// The same surface, named in the order of the coded base: positions, creases, materials, colours and fields moved
/// along.
SemiRegularMesh renumber(const SemiRegularMesh& source, const CodedBase& base);

/// The whole payload. mesh: after renumber().
Bytes write_base(const CodedBase& base, const SemiRegularMesh& mesh, const PartParams& params);

}  // namespace mvw
