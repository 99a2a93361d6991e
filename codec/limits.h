// Every cap that the decoder applies before it allocates. A file over a cap is refused with Errc::LimitExceeded.
#pragma once
#include <cstdint>

namespace mvw {

/// Caps of one decode. The defaults suit a desktop; a browser or a server thumbnailer lowers them.
struct Limits {
    std::uint32_t max_parts = 64;
    std::uint32_t max_levels = 12;            // 4^12 triangles for each base face
    std::uint32_t max_base_faces = 1u << 24;  // all parts together
    std::uint32_t max_tiles = 1u << 16;       // of one part
    std::uint32_t max_layers = 64;
    std::uint32_t max_channels = 16;
    std::uint32_t max_chunks = 1u << 24;
    std::uint32_t max_chunk_bytes = 1u << 28;
    std::uint32_t max_metadata_bytes = 1u << 20;
    std::uint64_t max_vertices = 1ull << 28;  // of the finest mesh handed out; a decode stops at the level that fits
    std::uint64_t max_memory_bytes = 8ull << 30;  // estimated before allocation
};

}  // namespace mvw
