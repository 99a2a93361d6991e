// Decodes rounds of vertex splits.
#pragma once
#include <algorithm>
#include <span>

#include "codec/bytes.h"
#include "codec/entropy/progressive_mesh.h"
#include "codec/result.h"

namespace mvw {

/// Splits vertices of the mesh, round by round, whose vertices then lie on `rounds`. whole: else the bytes are the
/// beginning of such, and what they determine is done (ProgressiveMesh::unrefined has what is not). Malformed where
/// they make no mesh of at most so many vertices and faces, or are fewer than least_bytes_of_splits(); the mesh is of
/// no use then. O(V + F) a round.
Result<void> decode_splits(std::span<const Lattice> rounds, ByteSpan bytes, bool whole, std::uint32_t most_vertices,
                           std::uint32_t most_faces, ProgressiveMesh& mesh);

/// Forged bytes take no more work than that. Encoders put zeros behind strings that are shorter. most: vertices after
/// the rounds.
constexpr std::size_t least_bytes_of_splits(std::uint64_t vertices, std::uint64_t most, std::size_t rounds) {
    constexpr std::uint64_t kMostSplitsPerByte = 64, kMostLooksPerByte = 16'384;
    return static_cast<std::size_t>(
        std::max((most - vertices) / kMostSplitsPerByte, most * rounds / kMostLooksPerByte) + 1);
}

inline constexpr const char* kNoSplits = "splits do not lead to the mesh that the header says";

}  // namespace mvw
