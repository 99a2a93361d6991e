#include "codec/container/enc_file.h"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "codec/container/crc32c.h"
#include "codec/container/head_fields.h"

namespace mvw {

namespace {

constexpr std::size_t kIdBytes = 16;

std::uint64_t zigzag(std::int64_t v) {
    return (static_cast<std::uint64_t>(v) << 1) ^ static_cast<std::uint64_t>(v >> 63);
}

void write_box(ByteWriter& out, const FileHeader& header) {
    int exponent = 0;
    const double fraction = std::frexp(header.diagonal, &exponent);
    out.u16(static_cast<std::uint16_t>(std::ldexp(fraction, 16)));
    out.u16(static_cast<std::uint16_t>(exponent - 16));
    for (const double c : header.center) out.varint(zigzag(std::llround(c / (header.diagonal / 64))));
}

void write_part(ByteWriter& out, const PartInfo& part) {
    out.u8(static_cast<std::uint8_t>(part.levels | (part.supersedes ? detail::kSupersedes : 0u) |
                                     (part.preview ? detail::kPreview : 0u) |
                                     (part.progressive ? detail::kProgressive : 0u)));
    out.varint(part.base_faces);
    out.varint(2ull * part.base_edges - 3ull * part.base_faces);
    out.varint(zigzag(std::int64_t{part.base_vertices} - part.base_edges + part.base_faces));
    out.varint(part.tiles);
    if (part.tiles > 1) out.u8(part.first_tiled_level);
}

/// All but magic, version and size in front and the check behind.
Bytes header_fields(const FileHeader& header, std::uint64_t body_bytes, std::uint64_t index_bytes, std::size_t& id_at) {
    ByteWriter out;
    out.varint(header.features);
    id_at = out.size();
    for (const std::uint8_t b : header.content_id) out.u8(b);
    write_box(out, header);
    out.u8(header.transform);
    out.u8(header.layers);
    out.varint(header.parts.size());
    for (const PartInfo& part : header.parts) write_part(out, part);
    out.varint(header.metadata.size());
    out.bytes(header.metadata);
    out.varint(body_bytes);
    out.varint(index_bytes);
    return out.take();
}

/// The header's bytes with the check left to seal(); id_at is where the content id stands.
Bytes header_bytes(const FileHeader& header, std::uint64_t body_bytes, std::uint64_t index_bytes, std::size_t& id_at) {
    const Bytes fields = header_fields(header, body_bytes, index_bytes, id_at);
    const std::size_t short_size = 3 + 1 + 1 + fields.size() + 2;
    const std::size_t size = short_size < 128              ? short_size
                             : short_size + 1 < (1u << 14) ? short_size + 1
                                                           : short_size + 2;
    ByteWriter out;
    for (const char c : {'M', 'V', 'W'}) out.u8(static_cast<std::uint8_t>(c));
    out.u8(static_cast<std::uint8_t>(kFormatVersion));
    out.varint(size);
    id_at += out.size();
    out.bytes(fields);
    out.u16(0);
    return out.take();
}

std::array<std::uint8_t, kIdBytes> hash(ByteSpan header, ByteSpan body) {
    XXH3_state_t* state = XXH3_createState();
    XXH3_128bits_reset(state);
    XXH3_128bits_update(state, header.data(), header.size());
    XXH3_128bits_update(state, body.data(), body.size());
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state));
    XXH3_freeState(state);
    std::array<std::uint8_t, kIdBytes> id{};
    std::copy(std::begin(canonical.digest), std::end(canonical.digest), id.begin());
    return id;
}

Bytes write_body(std::span<const ChunkToWrite> chunks) {
    ByteWriter out;
    ChunkId previous;
    for (const ChunkToWrite& c : chunks) {
        ByteWriter head;
        write_chunk_head(head, previous, c.id, static_cast<std::uint32_t>(c.payload.size()));
        out.bytes(head.view());
        out.u16(chunk_check(head.view(), c.payload));
        out.bytes(c.payload);
        previous = c.id;
    }
    return out.take();
}

/// FORMAT.md 5: rows as the heads are, then the checksums, then the errors.
Bytes index_table(std::span<const ChunkToWrite> chunks) {
    ByteWriter out;
    out.varint(chunks.size());
    ChunkId previous;
    for (const ChunkToWrite& c : chunks) {
        write_chunk_head(out, previous, c.id, static_cast<std::uint32_t>(c.payload.size()));
        previous = c.id;
    }
    for (const ChunkToWrite& c : chunks) out.u32(crc32c(c.payload));
    std::int64_t before = 0;
    for (const ChunkToWrite& c : chunks) {
        const std::int64_t centibel = error_to_disk(c.error);
        out.varint(zigzag(centibel - before));
        before = centibel;
    }
    return out.take();
}

Bytes write_index(std::span<const ChunkToWrite> chunks) {
    const Bytes table = index_table(chunks);
    Bytes packed(ZSTD_compressBound(table.size()));
    const std::size_t size = ZSTD_compress(packed.data(), packed.size(), table.data(), table.size(), 19);
    const bool pack = !ZSTD_isError(size) && size < table.size();
    ByteWriter out;
    out.u8(pack ? 1 : 0);
    out.bytes(pack ? ByteSpan(packed).first(size) : ByteSpan(table));
    out.u32(crc32c(out.view()));
    return out.take();
}

/// Puts the id and then the check into a header that has zeros there.
void seal(Bytes& header, std::size_t id_at, const std::array<std::uint8_t, kIdBytes>& id) {
    std::transform(id.begin(), id.end(), header.begin() + static_cast<std::ptrdiff_t>(id_at),
                   [](std::uint8_t b) { return std::byte{b}; });
    const std::uint32_t crc = crc32c(ByteSpan(header).first(header.size() - 2));
    header[header.size() - 2] = static_cast<std::byte>(crc);
    header[header.size() - 1] = static_cast<std::byte>(crc >> 8);
}

}  // namespace

Result<void> set_box(FileHeader& header, const std::array<double, 3>& center, double diagonal) {
    const Error bad{Errc::InvalidArgument, 0, "the model's box has no finite size"};
    if (!(diagonal >= 1e-280 && diagonal <= 1e280)) return bad;
    int exponent = 0;
    const double fraction = std::frexp(diagonal, &exponent);
    header.diagonal = std::ldexp(std::ceil(std::ldexp(fraction, 16)), exponent - 16);
    for (std::size_t k = 0; k < 3; ++k) {
        const double n = std::round(center[k] / (header.diagonal / 64));
        if (!(std::abs(n) < 4.5e15)) return bad;
        header.center[k] = n * (header.diagonal / 64);
    }
    return {};
}

Result<Bytes> write_file(FileHeader header, std::span<const ChunkToWrite> chunks, const Limits& limits) {
    for (const ChunkToWrite& c : chunks)
        if (c.payload.size() > limits.max_chunk_bytes)
            return Error{Errc::LimitExceeded, 0, "a chunk is longer than a chunk may be"};
    const Bytes body = write_body(chunks);
    const Bytes index = write_index(chunks);
    header.content_id = {};
    std::size_t id_at = 0;
    Bytes file = header_bytes(header, body.size(), index.size(), id_at);
    seal(file, id_at, hash(file, body));
    const Result<FileHeader> written = read_header(file, limits);
    if (!written.ok()) return written.error();
    file.insert(file.end(), body.begin(), body.end());
    file.insert(file.end(), index.begin(), index.end());
    if (const Result<Toc> toc = read_toc(*written, index, file.size(), limits); !toc.ok()) return toc.error();
    return file;
}

Result<std::array<std::uint8_t, 16>> content_id_of(ByteSpan file, const Limits& limits) {
    Result<FileHeader> header = read_header(file, limits);
    if (!header.ok()) return header.error();
    if (file.size() < header->index_offset) return Error{Errc::NeedMoreData, file.size(), "the chunks are incomplete"};
    header->content_id = {};
    std::size_t id_at = 0;
    const Bytes blank = header_bytes(*header, header->index_offset - header->header_bytes, header->index_bytes, id_at);
    return hash(blank, file.subspan(header->header_bytes, header->index_offset - header->header_bytes));
}

}  // namespace mvw
