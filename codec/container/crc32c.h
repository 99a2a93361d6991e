// CRC-32C (Castagnoli, reflected polynomial 0x82F63B78, as in RFC 3720): the checksum of every chunk. Eight table steps
// for eight bytes ("slicing by 8", Kounavis and Berry 2005); plain C++, so that the browser's decoder has it too.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "codec/bytes.h"
#include "codec/table.h"

namespace mvw {

namespace detail {

using CrcTables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr CrcTables make_crc32c_tables() {
    CrcTables t{};
    for (std::uint32_t i = 0; i < 256; ++i) {
        std::uint32_t c = i;
        for (int bit = 0; bit < 8; ++bit) c = (c >> 1) ^ (c & 1 ? 0x82F63B78u : 0u);
        t[0][i] = c;
    }
    for (std::size_t k = 1; k < 8; ++k)
        for (std::size_t i = 0; i < 256; ++i) t[k][i] = (t[k - 1][i] >> 8) ^ t[0][t[k - 1][i] & 0xFF];
    return t;
}
MVW_TABLE(kCrc32cTables, make_crc32c_tables());

}  // namespace detail

/// CRC-32C of bytes; `before` continues that of the bytes in front of them. crc32c("123456789") is 0xE3069283.
constexpr std::uint32_t crc32c(ByteSpan bytes, std::uint32_t before = 0) {
    const detail::CrcTables& t = detail::kCrc32cTables;
    std::uint32_t crc = ~before;
    std::size_t i = 0;
    const auto at = [&](std::size_t k) { return std::to_integer<std::uint32_t>(bytes[k]); };
    for (; i + 8 <= bytes.size(); i += 8) {
        crc ^= at(i) | at(i + 1) << 8 | at(i + 2) << 16 | at(i + 3) << 24;
        crc = t[7][crc & 0xFF] ^ t[6][(crc >> 8) & 0xFF] ^ t[5][(crc >> 16) & 0xFF] ^ t[4][crc >> 24] ^
              t[3][at(i + 4)] ^ t[2][at(i + 5)] ^ t[1][at(i + 6)] ^ t[0][at(i + 7)];
    }
    for (; i < bytes.size(); ++i) crc = (crc >> 8) ^ t[0][(crc ^ at(i)) & 0xFF];
    return ~crc;
}

}  // namespace mvw
