// The fast profile's planes: bytes of equal weight together, packed by zstd. Larger than what the range coder makes of
// them, and several times faster to decode (FORMAT.md 4.7). Both directions share the layout.
#pragma once
#include <cstddef>
#include <cstdint>

#include "codec/bytes.h"
#include "codec/entropy/plane_coder.h"

namespace mvw {

/// Of one entry: its bits at the planes `low` to `top`, above a sign bit that is set where it is negative and becomes
/// significant in these planes.
constexpr std::uint32_t packed_word(std::uint32_t entry, unsigned top, unsigned low) {
    const std::uint32_t magnitude = magnitude_of(entry);
    const std::uint32_t bits = (magnitude >> low) & ((std::uint32_t{2} << (top - low)) - 1);
    const bool says_sign = magnitude >> (top + 1) == 0 && bits != 0;
    return bits << 1 | (says_sign ? entry & 1u : 0);
}
/// Bytes of a word.
constexpr std::size_t packed_width(unsigned top, unsigned low) {
    return (top - low + 2 + 7) / 8;
}

/// A chunk's payload behind its front: byte k of all words of component 0, then of component 1 and so on, for k from 0
/// up; as a zstd frame with its content size. Encoder only.
Bytes pack_planes(const Entries& entries, unsigned components, unsigned top, unsigned low);

/// Whether these bytes are one whole frame of the size that so many entries take, as far as its heads say: unzip_planes()
/// may still find it damaged.
bool is_packed_planes(ByteSpan packed, std::size_t entries, unsigned top, unsigned low);
/// The bytes behind the frame. False where it is not one of exactly the size that so many entries take.
bool unzip_planes(ByteSpan packed, std::size_t entries, unsigned top, unsigned low, Bytes& raw);
/// Sets those planes in the entries, which are component-major (entry i of component c at c * coefficients + i).
void unpack_planes(ByteSpan raw, unsigned top, unsigned low, std::span<std::uint32_t> entries);

}  // namespace mvw
