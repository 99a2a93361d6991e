// Sets of numbers that grow together: for each number one of its set, by which find_root() finds the smallest.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace mvw {

/// Smallest member of v's set; halves the path on the way. Every number starts as its own parent.
inline std::uint32_t find_root(std::vector<std::uint32_t>& parent, std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

inline void unite(std::vector<std::uint32_t>& parent, std::uint32_t v, std::uint32_t w) {
    v = find_root(parent, v), w = find_root(parent, w);
    parent[std::max(v, w)] = std::min(v, w);
}

}  // namespace mvw
