#include <zstd.h>

#include "codec/entropy/packed_planes.h"

namespace mvw {

Bytes pack_planes(const Entries& entries, unsigned components, unsigned top, unsigned low) {
    const std::size_t width = packed_width(top, low), count = entries.size() / components;
    Bytes raw(entries.size() * width);
    for (std::size_t at = 0; at < entries.size(); ++at) {
        const std::uint32_t word = packed_word(entries[at], top, low);
        const std::size_t place = at % components * count + at / components;
        for (std::size_t k = 0; k < width; ++k)
            raw[k * entries.size() + place] = static_cast<std::byte>(word >> (8 * k));
    }
    Bytes packed(ZSTD_compressBound(raw.size()));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), 19));
    return packed;
}

}  // namespace mvw
