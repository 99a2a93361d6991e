#include <zstd.h>

#include <algorithm>

#include "codec/entropy/packed_planes.h"

namespace mvw {

bool unzip_planes(ByteSpan packed, std::size_t entries, unsigned top, unsigned low, Bytes& raw) {
    const std::size_t size = entries * packed_width(top, low);
    if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != size) return false;
    raw.resize(size);
    return ZSTD_decompress(raw.data(), raw.size(), packed.data(), packed.size()) == raw.size();
}

void unpack_planes(ByteSpan raw, unsigned components, unsigned top, unsigned low, std::span<EntryRow> rows) {
    const std::size_t width = packed_width(top, low), count = rows.size();
    const std::uint32_t mask = (std::uint32_t{2} << (top - low)) - 1;
    std::vector<std::uint32_t> words(count);
    for (unsigned c = 0; c < components; ++c) {
        // Byte by byte over all words: loops that the compiler makes vectors of.
        std::fill(words.begin(), words.end(), 0u);
        for (std::size_t k = 0; k < width; ++k) {
            const std::byte* from = &raw[(k * components + c) * count];
            for (std::size_t i = 0; i < count; ++i) words[i] |= std::to_integer<std::uint32_t>(from[i]) << (8 * k);
        }
        for (std::size_t i = 0; i < count; ++i) {
            std::uint32_t& entry = rows[i].of[c];
            const std::uint32_t bits = (words[i] >> 1) & mask;
            const std::uint32_t says_sign = std::uint32_t{entry == 0} & std::uint32_t{bits != 0};
            entry |= bits << (low + 1) | (words[i] & says_sign);
        }
    }
}

}  // namespace mvw
