// Reads a Base chunk: connectivity and coarse positions of one part's level 0, creases, labels, parameters.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/container/toc.h"
#include "codec/entropy/dec_mesh.h"
#include "codec/mesh/semi_regular.h"
#include "codec/part_params.h"

namespace mvw {

/// What is wrong with a progressive part that has creases, attributes, another transform or a lattice of too many bits,
/// or is lossless.
inline constexpr const char* kCannotSplit = "a progressive part holds what splits do not keep";

/// How a base's mesh is coded: by Draco's edgebreaker or sequential method, or triangle by triangle
/// (entropy/mesh_coder.h).
enum class BaseMethod : std::uint8_t { Edgebreaker, Sequential, Grown };

/// Level 0 of one part as its Base chunk holds it.
struct DecodedBase {
    PartParams params;
    BaseMesh mesh;
    std::vector<GridPoint> grid;           // V positions on params.lattice
    std::vector<std::uint8_t> creases;     // empty, or one for each edge
    std::vector<std::uint32_t> materials;  // empty, or one for each face
};

/// FORMAT.md 4.1. Counts must be those of `info`; they are held against the bytes present (at most kMaxFacesPerByte
/// faces for each) before anything is allocated.
Result<DecodedBase> read_base(ByteSpan payload, const PartInfo& info, std::uint8_t transform);

inline constexpr std::uint64_t kMaxFacesPerByte = 256;
/// Draco's answer to its own bytes (without the 11 in front that never change), in its order of faces and vertices.
/// Malformed where Draco refuses, or the counts in front are not exactly `faces` and at most `vertices`.
Result<GridMesh> read_draco(ByteSpan bytes, bool sequential, std::uint32_t vertices, std::uint32_t faces);

}  // namespace mvw
