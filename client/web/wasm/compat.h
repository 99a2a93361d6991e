// What C++20 has and the standard library of emscripten 3.1.6 lacks; included before every file of this build.
#pragma once
#include <version>
#if !defined(__cpp_lib_bit_cast)
namespace std {
template <typename To, typename From>
constexpr To bit_cast(const From& from) noexcept {
    return __builtin_bit_cast(To, from);
}
}  // namespace std
#endif
