// The fields that a chunk's head and its row of the index share. Inside the container room only.
#pragma once
#include "codec/container/chunk.h"

namespace mvw::detail {

/// Beside the levels of a part that stands for all others (PartInfo::supersedes).
inline constexpr unsigned kSupersedes = 128;
/// Likewise of one that is shown before the others are (PartInfo::preview).
inline constexpr unsigned kPreview = 64;
/// Likewise of one that grows by splits (PartInfo::progressive).
inline constexpr unsigned kProgressive = 32;

/// Reads id and length as write_chunk_head() wrote them; errors as read_chunk_head()'s.
Result<void> read_head_fields(ByteReader& in, const ChunkId& previous, const Limits& limits, ChunkId& id,
                              std::uint32_t& length);

}  // namespace mvw::detail
