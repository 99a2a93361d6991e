// Writes the input mesh into a chunk of its own.
#pragma once
#include "codec/container/toc.h"
#include "codec/mesh/mesh.h"

namespace mvw {

/// The payload of FORMAT.md 4.6: positions rounded to 2^-bits of the diagonal, connectivity exact, by Draco's best
/// level; its colours are left out. bits: 1 to 30. Empty where Draco cannot code the mesh.
Bytes write_original(const Mesh& mesh, const FileHeader& header, unsigned bits);

}  // namespace mvw
