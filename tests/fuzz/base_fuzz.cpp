// Any bytes as the payload of a Base chunk are a mesh of the header's counts or refused, without Draco taking memory
// out of proportion. Byte 0: how many vertices and faces the header claims.
#include <cstdint>
#include <cstdlib>

#include "codec/dec_base.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 1) return 0;
    const std::uint32_t faces = 1 + data[0] % 64;
    const auto* begin = reinterpret_cast<const std::byte*>(data);
    const mvw::Bytes payload(begin + 1, begin + size);  // a block of its own, so that reading past it is seen
    for (const std::uint8_t levels : {std::uint8_t{0}, std::uint8_t{3}})
        for (const std::uint32_t boundary : {0u, 3u}) {
            const std::uint32_t edges = (3 * faces + boundary) / 2;
            const mvw::PartInfo info{levels, edges - faces + (boundary > 0 ? 1u : 2u), edges, faces, 1};
            const auto base = mvw::read_base(payload, info, 9);
            if (base.ok() && (base->grid.size() != info.base_vertices || base->mesh.face_count() != faces))
                std::abort();
        }
    return 0;
}
