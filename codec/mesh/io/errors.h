// What readers answer instead of a mesh.
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "codec/result.h"

namespace mvw {

inline Error malformed(std::string reason) {
    return {Errc::Malformed, 0, std::move(reason)};
}

/// Vertices and corners that a file of so many bytes may unfold to where it places a mesh again and again: some times
/// its bytes, and never so many that memory runs out.
inline std::uint64_t budget_of_instances(std::uint64_t bytes) {
    constexpr std::uint64_t kFree = 1'000'000, kTimes = 1000, kMost = 100'000'000;
    return std::min(kFree + kTimes * bytes, std::max(kMost, bytes));
}

inline Error over_budget() {
    return {Errc::LimitExceeded, 0, "places its meshes so often that they are too large together"};
}

}  // namespace mvw
