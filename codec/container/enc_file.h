// Writes .mvw files: the encoder's last step, and what a client does with the chunks that it has received. FORMAT.md
// 2, 3 and 5 are normative.
#pragma once
#include <span>

#include "codec/container/toc.h"

namespace mvw {

/// A chunk to be written.
struct ChunkToWrite {
    ChunkId id;
    ByteSpan payload;
    float error = 0;  // as ChunkEntry::error
};

/// The nearest box that a header can hold: a diagonal at most 2^-15 longer, a centre on a grid of diagonal / 64.
/// InvalidArgument where the box is empty, a point, not finite, or its diagonal below 1e-280 or above 1e280.
Result<void> set_box(FileHeader& header, const std::array<double, 3>& center, double diagonal);

/// A whole file of these chunks in this order. Of the header all is taken over but its sizes, version and content id. A
/// subset of a file's chunks gives a valid file again if lower layers come with higher ones. Malformed, LimitExceeded
/// where the result would not be valid (read_toc's rules).
Result<Bytes> write_file(FileHeader header, std::span<const ChunkToWrite> chunks, const Limits& limits = {});

/// The content id that a file should carry: XXH3-128 of its header (id and check zeroed) and all chunks.
Result<std::array<std::uint8_t, 16>> content_id_of(ByteSpan file, const Limits& limits = {});

}  // namespace mvw
