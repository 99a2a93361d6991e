#include "codec/enc_original.h"

#include <cmath>

#include "codec/dec_original.h"
#include "codec/enc_base.h"

namespace mvw {

Bytes write_original(const Mesh& mesh, const FileHeader& header, unsigned bits) {
    std::vector<std::array<std::int32_t, 3>> grid(mesh.positions.size());
    const double scale = std::ldexp(1.0, static_cast<int>(bits)) / header.diagonal;
    for (std::size_t v = 0; v < grid.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k)
            grid[v][k] = static_cast<std::int32_t>(std::lround((mesh.positions[v][k] - header.center[k]) * scale));
    // Edgebreaker splits what is not a manifold: then sequentially, which keeps every vertex.
    for (const bool sequential : {false, true}) {
        ByteWriter out;
        out.u8(sequential ? 1 : 0);
        out.u8(static_cast<std::uint8_t>(bits));
        out.varint(mesh.positions.size());
        out.varint(mesh.faces.size());
        out.bytes(write_draco(mesh.faces, grid, sequential, 0));
        const Result<Mesh> back = read_original(out.view(), header);
        if (back.ok() && back->positions.size() == mesh.positions.size() && back->faces.size() == mesh.faces.size())
            return out.take();
    }
    return {};
}

}  // namespace mvw
