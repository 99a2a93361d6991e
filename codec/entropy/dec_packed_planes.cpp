#include <zstd.h>

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
    for (unsigned c = 0; c < components; ++c)
        for (std::size_t i = 0; i < count; ++i) {
            std::uint32_t word = 0;
            for (std::size_t k = 0; k < width; ++k)
                word |= std::to_integer<std::uint32_t>(raw[(k * components + c) * count + i]) << (8 * k);
            std::uint32_t& entry = rows[i].of[c];
            const bool was_zero = entry == 0;
            const std::uint32_t bits = (word >> 1) & mask;
            entry |= bits << (low + 1);
            if (was_zero && bits != 0) entry |= word & 1u;
        }
}

}  // namespace mvw
