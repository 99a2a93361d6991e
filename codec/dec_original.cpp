#include "codec/dec_original.h"

#include <algorithm>
#include <cmath>

#include "codec/container/crc32c.h"
#include "codec/dec_base.h"

namespace mvw {

namespace {

constexpr std::uint64_t kBytesPerFace = 256;  // that Draco and its answer take at most
constexpr unsigned kMostBits = 30;

Error malformed(const char* what) {
    return {Errc::Malformed, 0, what};
}

}  // namespace

Result<Mesh> read_original(ByteSpan payload, const FileHeader& header, const Limits& limits) {
    ByteReader in(payload);
    const unsigned flags = in.u8(), bits = in.u8();
    const std::uint64_t vertices = in.varint(), faces = in.varint();
    if (!in.ok()) return malformed("the original mesh is cut");
    if (flags > 1) return Error{Errc::Unsupported, 0, "the original mesh has unknown flags"};
    if (bits < 1 || bits > kMostBits) return malformed("the original mesh's precision is out of range");
    if (vertices > limits.max_vertices || faces > limits.max_memory_bytes / kBytesPerFace)
        return Error{Errc::LimitExceeded, 0, "the original mesh takes more vertices or memory than the limit"};
    if (faces == 0 || faces >= kNone || vertices > 3 * faces) return malformed("the original mesh's counts are wrong");
    const Result<GridMesh> mesh = read_draco(in.bytes(in.remaining()), flags == 1, static_cast<std::uint32_t>(vertices),
                                             static_cast<std::uint32_t>(faces));
    if (!mesh.ok()) return mesh.error();
    const double step = std::ldexp(header.diagonal, -static_cast<int>(bits));
    Mesh out;
    out.faces = mesh->faces;
    out.positions.reserve(mesh->grid.size());
    for (const auto& g : mesh->grid)
        out.positions.push_back(
            {header.center[0] + g[0] * step, header.center[1] + g[1] * step, header.center[2] + g[2] * step});
    return out;
}

Result<Mesh> decode_original(ByteSpan file, const Limits& limits) {
    const Result<FileHeader> header = read_header(file, limits);
    if (!header.ok()) return header.error();
    if (file.size() < header->file_bytes()) return Error{Errc::NeedMoreData, file.size(), "the file is cut"};
    file = file.first(header->file_bytes());
    const Result<Toc> toc = read_toc(*header, file.subspan(header->index_offset), file.size(), limits);
    if (!toc.ok()) return toc.error();
    const auto chunk = std::find_if(toc->chunks.begin(), toc->chunks.end(),
                                    [](const ChunkEntry& c) { return c.id.channel == Channel::Original; });
    if (chunk == toc->chunks.end()) return Error{Errc::InvalidArgument, 0, "the file does not hold its original mesh"};
    const ByteSpan payload = file.subspan(chunk->offset, chunk->length);
    if (crc32c(payload) != chunk->crc32c) return malformed("the original mesh's checksum is wrong");
    return read_original(payload, *header, limits);
}

}  // namespace mvw
