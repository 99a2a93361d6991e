#include "codec/container/chunk.h"

#include "codec/container/crc32c.h"
#include "codec/container/head_fields.h"

namespace mvw {

Result<ChunkHead> read_chunk_head(ByteReader& in, const ChunkId& previous, const Limits& limits) {
    ChunkHead head;
    if (const Result<void> r = detail::read_head_fields(in, previous, limits, head.id, head.length); !r.ok())
        return r.error();
    head.check = in.u16();
    if (!in.ok()) return in.error();
    return head;
}

void write_chunk_head(ByteWriter& out, const ChunkId& previous, const ChunkId& id, std::uint32_t length) {
    const bool new_part = id.part != previous.part, new_tile = id.tile != previous.tile;
    out.u8(static_cast<std::uint8_t>(id.level | static_cast<unsigned>(id.channel) << 4));
    out.u8(static_cast<std::uint8_t>(id.layer | (new_part ? 0x40u : 0u) | (new_tile ? 0x80u : 0u)));
    if (new_part) out.varint(id.part);
    if (new_tile) out.varint(id.tile);
    out.varint(length);
}

std::uint16_t chunk_check(ByteSpan head, ByteSpan payload) {
    return static_cast<std::uint16_t>(crc32c(payload, crc32c(head)));
}

namespace detail {

Result<void> read_head_fields(ByteReader& in, const ChunkId& previous, const Limits& limits, ChunkId& id,
                              std::uint32_t& length) {
    const std::size_t at = in.offset();
    const unsigned first = in.u8(), second = in.u8();
    const std::uint64_t part = second & 0x40u ? in.varint() : previous.part;
    const std::uint64_t tile = second & 0x80u ? in.varint() : previous.tile;
    const std::uint64_t bytes = in.varint();
    if (!in.ok()) return in.error();
    id.channel = Channel{static_cast<std::uint8_t>(first >> 4)};
    id.level = static_cast<std::uint8_t>(first & 0x0Fu);
    id.layer = static_cast<std::uint8_t>(second & 0x3Fu);
    if (part >= limits.max_parts) return Error{Errc::LimitExceeded, at, "a chunk names part " + std::to_string(part)};
    if (tile >= limits.max_tiles) return Error{Errc::LimitExceeded, at, "a chunk names tile " + std::to_string(tile)};
    id.part = static_cast<std::uint16_t>(part);
    id.tile = static_cast<std::uint16_t>(tile);
    if (bytes > limits.max_chunk_bytes)
        return Error{
            Errc::LimitExceeded, at,
            "a chunk of " + std::to_string(bytes) + " bytes, limit is " + std::to_string(limits.max_chunk_bytes)};
    length = static_cast<std::uint32_t>(bytes);
    return {};
}

}  // namespace detail

}  // namespace mvw
