// Tables that functions make: part of the program, except in a browser, where every byte of the program travels and
// they are made as it starts.
#pragma once

#if defined(__EMSCRIPTEN__)
/// The assembly keeps the compiler from working the table out after all.
#define MVW_TABLE(name, value)             \
    inline const auto name = [] {          \
        __asm__ volatile("" ::: "memory"); \
        return value;                      \
    }()
#else
#define MVW_TABLE(name, value) inline constexpr auto name = value
#endif
