// What a .mvw file is made of, as the server and the client see it: a header, chunks in file order, and the table that
// finds them. No geometry here; FORMAT.md 2 and 3 are normative.
#pragma once
#include <array>
#include <compare>
#include <cstdint>
#include <vector>

#include "codec/bytes.h"
#include "codec/limits.h"
#include "codec/result.h"

namespace mvw {

/// What a chunk carries. On disk: append values, never renumber (FORMAT.md 3.1). A reader skips those it does not know.
enum class Channel : std::uint8_t {
    Base = 0,         // connectivity, coarse positions, creases and labels of one part's level 0
    Geometry = 1,     // position coefficients of one (part, tile, level, layer); level 0: what the base's rounding left
    Color = 2,        // colour coefficients, likewise
    Original = 3,     // the input mesh itself (Draco), one chunk a file
    FirstField = 4,   // coefficients of the part's first field (normals, a scalar), likewise; those behind have the
    LastField = 11,   // numbers that follow
    Attributes = 12,  // what the part's colours and fields are, one chunk a part
    Splits = 13,      // vertex splits of a progressive part; they follow one another by layer
};
inline constexpr unsigned kMaxFields = 8;

/// Whether chunks of a channel make up level 0, which all others build on.
constexpr bool leads_to_base(Channel channel) {
    return channel == Channel::Base || channel == Channel::Splits;
}

/// Names a chunk. Ordered: a chunk can be decoded once the part's Base chunk (and its Attributes chunk where it is of
/// one of these) and all lower layers that the file has of
/// the same (part, tile, level, channel) are there; coarser levels that are absent count as zero details. Layers of one
/// block may skip numbers: a chunk carries all that its block has above the next lower one.
struct ChunkId {
    std::uint16_t part = 0;
    std::uint16_t tile = 0;  // 0 for Base, Original, Attributes and Splits
    std::uint8_t level = 0;  // likewise; at most 15
    std::uint8_t layer = 0;  // 0 = coarsest quantiser step; likewise; at most 63
    Channel channel = Channel::Base;
    friend constexpr auto operator<=>(const ChunkId&, const ChunkId&) = default;
};

/// One chunk's place in the file.
struct ChunkEntry {
    ChunkId id;
    std::uint64_t offset = 0;  // of its payload from the start of the file
    std::uint32_t length = 0;  // payload bytes
    std::uint32_t crc32c = 0;  // of the payload
    float error = 0;           // RMS surface error left after this chunk and all before it, fraction of the diagonal
};

/// What stands in front of each payload: 5 to 15 bytes (FORMAT.md 3.2).
struct ChunkHead {
    ChunkId id;
    std::uint32_t length = 0;  // payload bytes
    std::uint16_t check = 0;   // low half of the CRC-32C of the head's other bytes and the payload
};

/// Reads the head at the reader's place; `previous` is the id before it in the file (a default one at the start).
/// NeedMoreData where the bytes end within it; Malformed, LimitExceeded as they say.
Result<ChunkHead> read_chunk_head(ByteReader& in, const ChunkId& previous, const Limits& limits = {});

/// The head's bytes without its check: what the index holds, and what the check covers before the payload.
void write_chunk_head(ByteWriter& out, const ChunkId& previous, const ChunkId& id, std::uint32_t length);

/// The check of a head whose other bytes are `head`.
std::uint16_t chunk_check(ByteSpan head, ByteSpan payload);

}  // namespace mvw
