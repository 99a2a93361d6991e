#include "codec/mesh/number_positions.h"

#include <bit>

#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Open addressing over the bit patterns.
std::vector<std::uint32_t> number_positions(std::span<const Vec3> positions) {
    const std::size_t slots = std::bit_ceil(2 * positions.size() + 1);
    std::vector<std::uint32_t> table(slots, kNone), number(positions.size());
    const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x + 0.0); };
    std::uint32_t count = 0;
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
        const Vec3& p = positions[v];
        std::uint64_t key = bits(p.x) * 0x9E3779B97F4A7C15u;
        key = (key ^ (key >> 29) ^ bits(p.y)) * 0xBF58476D1CE4E5B9u;
        key = (key ^ (key >> 32) ^ bits(p.z)) * 0x94D049BB133111EBu;
        std::size_t slot = (key ^ (key >> 31)) & (slots - 1);
        while (table[slot] != kNone && !(positions[table[slot]] == p)) slot = (slot + 1) & (slots - 1);
        const bool found = table[slot] != kNone;
        number[v] = found ? number[table[slot]] : count++;
        if (!found) table[slot] = v;
    }
    return number;
}

}  // namespace mvw
