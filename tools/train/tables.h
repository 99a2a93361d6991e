// What the trainers write: numbers of a byte, as C++ tables on standard output.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace mvw {

inline std::int8_t rounded(double x) {
    return static_cast<std::int8_t>(std::clamp(std::round(x), -127.0, 127.0));
}

template <typename Table>
void print(const char* name, const Table& table) {
    std::printf("inline constexpr std::array<std::int8_t, %zu> %s{", table.size(), name);
    for (std::size_t k = 0; k < table.size(); ++k) std::printf("%s%d", k == 0 ? "" : ", ", table[k]);
    std::printf("};\n");
}

}  // namespace mvw
