#include "codec/container/toc.h"

#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "codec/container/crc32c.h"
#include "codec/container/head_fields.h"

namespace mvw {

namespace {

Error malformed(std::size_t offset, std::string message) {
    return {Errc::Malformed, offset, std::move(message)};
}
Error over_limit(std::size_t offset, const char* what, std::uint64_t value, std::uint64_t limit) {
    return {Errc::LimitExceeded, offset,
            std::string(what) + " is " + std::to_string(value) + ", limit is " + std::to_string(limit)};
}

std::int64_t unzigzag(std::uint64_t v) {
    return static_cast<std::int64_t>(v >> 1) ^ -static_cast<std::int64_t>(v & 1);
}

/// FORMAT.md 2.3: edges and vertices follow from the boundary edges and the Euler characteristic.
Result<PartInfo> read_part(ByteReader& in, const Limits& limits) {
    const std::size_t at = in.offset();
    PartInfo part;
    const unsigned first = in.u8();
    part.supersedes = (first & detail::kSupersedes) != 0;
    part.preview = (first & detail::kPreview) != 0;
    part.progressive = (first & detail::kProgressive) != 0;
    part.levels = static_cast<std::uint8_t>(first & ~(detail::kSupersedes | detail::kPreview | detail::kProgressive));
    const std::uint64_t faces = in.varint(), boundary = in.varint();
    const std::int64_t euler = unzigzag(in.varint());
    const std::uint64_t tiles = in.varint();
    if (tiles > 1) part.first_tiled_level = in.u8();
    if (!in.ok()) return in.error();
    if (part.levels > limits.max_levels || part.levels > 15)
        return over_limit(at, "a part's level count", part.levels, limits.max_levels);
    if (faces > limits.max_base_faces) return over_limit(at, "a part's base face count", faces, limits.max_base_faces);
    if (tiles > limits.max_tiles || tiles > 0xFFFF)
        return over_limit(at, "a part's tile count", tiles, limits.max_tiles);
    if (faces == 0 || tiles == 0 || tiles > faces)
        return malformed(at, "a part has no face, no tile, or a tile without faces");
    if (boundary > 3 * faces || (3 * faces + boundary) % 2 != 0)
        return malformed(at, "a part's boundary edges do not fit its faces");
    if (part.first_tiled_level > part.levels) return malformed(at, "a part is tiled from a level on that it has not");
    const auto edges = static_cast<std::int64_t>((3 * faces + boundary) / 2);
    const auto most = static_cast<std::int64_t>(3 * faces);
    if (euler > most || euler < -most) return malformed(at, "a part's Euler characteristic does not fit its faces");
    const std::int64_t vertices = euler + edges - static_cast<std::int64_t>(faces);
    if (vertices < 3 || vertices > most) return malformed(at, "a part's vertices do not fit its faces");
    part.base_faces = static_cast<std::uint32_t>(faces);
    part.base_edges = static_cast<std::uint32_t>(edges);
    part.base_vertices = static_cast<std::uint32_t>(vertices);
    part.tiles = static_cast<std::uint16_t>(tiles);
    return part;
}

Result<void> read_parts(ByteReader& in, const Limits& limits, FileHeader& header) {
    const std::size_t at = in.offset();
    const std::uint64_t count = in.varint();
    if (!in.ok()) return in.error();
    if (count > limits.max_parts) return over_limit(at, "the part count", count, limits.max_parts);
    if (count == 0) return malformed(at, "the file has no parts");
    std::uint64_t faces = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        Result<PartInfo> part = read_part(in, limits);
        if (!part.ok()) return part.error();
        const bool of_all = part->supersedes || part->preview;
        if (of_all && (i == 0 || part->levels > 0))
            return malformed(at, "a preview or a closing part has levels or is the first");
        if (i > 0 && (header.parts.back().supersedes || (header.parts.back().preview && !part->supersedes)))
            return malformed(at, "a part follows the preview or the closing one");
        if (part->supersedes && part->preview) return malformed(at, "a preview is a closing part");
        if (part->progressive && (part->levels > 0 || part->supersedes || (count > 1 && !part->preview)))
            return malformed(at, "a progressive part has levels, or is neither alone nor a preview");
        faces += part->base_faces;
        header.parts.push_back(*part);
    }
    if (faces > limits.max_base_faces) return over_limit(at, "the base face count", faces, limits.max_base_faces);
    return {};
}

Result<void> read_box(ByteReader& in, FileHeader& header) {
    const std::size_t at = in.offset();
    const std::uint16_t mantissa = in.u16();
    const auto exponent = static_cast<std::int16_t>(in.u16());
    header.diagonal = std::ldexp(static_cast<double>(mantissa), exponent);
    if (in.ok() && (mantissa < 0x8000 || exponent < -1000 || exponent > 1000))
        return malformed(at, "the diagonal is not a normalised positive number");
    for (double& c : header.center) {
        const std::int64_t n = unzigzag(in.varint());
        if (n > (std::int64_t{1} << 52) || n < -(std::int64_t{1} << 52))
            return malformed(at, "the centre is out of range");
        c = static_cast<double>(n) * (header.diagonal / 64);
    }
    return {};
}

/// The fields behind header_bytes, in disk order (FORMAT.md 2).
Result<void> read_fields(ByteReader& in, const Limits& limits, FileHeader& header) {
    const std::uint64_t features = in.varint();
    if (features & ~std::uint64_t{kKnownFeatures})
        return Error{Errc::Unsupported, in.offset(), "the file needs features that this build does not know"};
    header.features = static_cast<std::uint32_t>(features);
    for (std::uint8_t& b : header.content_id) b = in.u8();
    if (const Result<void> r = read_box(in, header); !r.ok()) return r;
    header.transform = in.u8();
    header.layers = in.u8();
    if (header.layers > limits.max_layers)
        return over_limit(in.offset(), "the layer count", header.layers, limits.max_layers);
    if (const Result<void> r = read_parts(in, limits, header); !r.ok()) return r;
    const std::uint64_t metadata_bytes = in.varint();
    if (metadata_bytes > limits.max_metadata_bytes)
        return over_limit(in.offset(), "the metadata's size", metadata_bytes, limits.max_metadata_bytes);
    const ByteSpan metadata = in.bytes(metadata_bytes);
    header.metadata.assign(metadata.begin(), metadata.end());
    const std::uint64_t body_bytes = in.varint(), index_bytes = in.varint();
    if (body_bytes > (std::uint64_t{1} << 48)) return malformed(in.offset(), "the chunks' total size is absurd");
    if (index_bytes > 0xFFFFFFFFu) return malformed(in.offset(), "the index's size is absurd");
    header.index_offset = header.header_bytes + body_bytes;
    header.index_bytes = static_cast<std::uint32_t>(index_bytes);
    return {};
}

}  // namespace

Result<FileHeader> read_header(ByteSpan prefix, const Limits& limits) {
    constexpr std::array<std::uint8_t, 3> kMagic{'M', 'V', 'W'};
    for (std::size_t i = 0; i < std::min(prefix.size(), kMagic.size()); ++i)
        if (std::to_integer<std::uint8_t>(prefix[i]) != kMagic[i]) return malformed(0, "not an mvw file");
    ByteReader start(prefix);
    start.bytes(kMagic.size());
    FileHeader header;
    header.version = start.u8();
    if (start.ok() && header.version != kFormatVersion)
        return Error{Errc::Unsupported, 3,
                     "the file is of version " + std::to_string(header.version) + ", this build knows version " +
                         std::to_string(kFormatVersion)};
    const std::uint64_t header_bytes = start.varint();
    if (!start.ok()) return start.error();
    const std::uint64_t most = std::uint64_t{limits.max_metadata_bytes} + 128 + 32ull * limits.max_parts;
    if (header_bytes > most) return over_limit(start.offset(), "the header's size", header_bytes, most);
    if (header_bytes < start.offset() + 2) return malformed(start.offset(), "the header's size is too small");
    if (prefix.size() < header_bytes) return Error{Errc::NeedMoreData, prefix.size(), "the header ends too early"};
    header.header_bytes = static_cast<std::uint32_t>(header_bytes);

    const ByteSpan covered = prefix.first(header.header_bytes - 2);
    ByteReader check(prefix.subspan(header.header_bytes - 2, 2));
    if (check.u16() != static_cast<std::uint16_t>(crc32c(covered)))
        return malformed(header.header_bytes - 2, "the header's checksum is wrong");
    ByteReader in(covered);
    in.bytes(start.offset());
    if (const Result<void> r = read_fields(in, limits, header); !r.ok()) {
        if (r.error().code != Errc::NeedMoreData) return r.error();
    }
    if (!in.ok() || in.remaining() != 0) return malformed(in.offset(), "the header's fields do not fill its size");
    return header;
}

namespace {

Error not_there(const char* what, unsigned number, unsigned count) {
    return malformed(
        0, std::string("a chunk names ") + what + ' ' + std::to_string(number) + " of " + std::to_string(count));
}

}  // namespace

Result<void> check_chunk_id(const FileHeader& header, const ChunkId& id) {
    if (id.part >= header.parts.size()) return not_there("part", id.part, static_cast<unsigned>(header.parts.size()));
    const PartInfo& part = header.parts[id.part];
    const bool untiled =
        id.channel == Channel::Base || id.channel == Channel::Original || id.channel == Channel::Attributes;
    const bool splits = id.channel == Channel::Splits;
    if ((untiled || splits) && (id.tile != 0 || id.level != 0 || (untiled && id.layer != 0)))
        return malformed(0, "a chunk of all of a part names a tile, level or layer");
    if (splits && !part.progressive) return malformed(0, "a chunk splits vertices of a part that is not progressive");
    if (id.tile >= part.tiles) return not_there("tile", id.tile, part.tiles);
    if (id.tile > 0 && id.level < part.first_tiled_level)
        return malformed(0, "a chunk names a tile of an untiled level");
    if (id.level > part.levels) return not_there("level", id.level, part.levels + 1u);
    if (!untiled && !splits && id.layer >= header.layers) return not_there("layer", id.layer, header.layers);
    return {};
}

std::size_t chunks_until_shown(const Toc& toc) {
    const std::size_t main = toc.header.main_parts();
    std::size_t bases = 0;
    for (std::size_t i = 0; i < toc.chunks.size(); ++i) {
        const ChunkId& id = toc.chunks[i].id;
        if (id.channel != Channel::Base) continue;
        const bool is_preview = id.part >= main && toc.header.parts[id.part].preview;
        bases += id.part < main;
        if (is_preview || bases == main) return i + 1;
    }
    return toc.chunks.size();
}

unsigned finest_level(const FileHeader& header) {
    unsigned level = 0;
    for (const PartInfo& part : header.parts) level = std::max<unsigned>(level, part.levels);
    return level;
}

bool in_layers(const FileHeader& header, const ChunkId& id, unsigned layer) {
    if (header.parts[id.part].supersedes) return layer + 1 >= header.layers;
    return id.layer <= layer || leads_to_base(id.channel);
}

std::uint16_t error_to_disk(double error) {
    if (!(error > 0)) return 0xFFFF;
    return static_cast<std::uint16_t>(std::clamp(std::round(-2000 * std::log10(error)), 0.0, 65534.0));
}
float error_from_disk(std::uint16_t centibel) {
    return centibel == 0xFFFF ? 0.0f : static_cast<float>(std::pow(10.0, -centibel / 2000.0));
}

namespace {

/// The table's bytes out of the index: method byte, bytes or a zstd frame, CRC-32C of both (FORMAT.md 5).
Result<Bytes> unpack_index(ByteSpan index, std::uint64_t file_bytes) {
    if (index.size() < 5) return malformed(0, "the index is too short");
    const ByteSpan covered = index.first(index.size() - 4);
    ByteReader check(index.last(4));
    if (check.u32() != crc32c(covered)) return malformed(0, "the index's checksum is wrong");
    const auto method = std::to_integer<std::uint8_t>(covered[0]);
    const ByteSpan packed = covered.subspan(1);
    if (method == 0) return Bytes(packed.begin(), packed.end());
    if (method != 1) return Error{Errc::Unsupported, 0, "the index's packing is unknown"};
    const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
    // Each row stands for at least a head of 5 bytes in the file, and takes at most 24 itself.
    if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR || size > 5 * file_bytes + 16)
        return malformed(0, "the index's size does not fit the file");
    Bytes table(size);
    if (ZSTD_decompress(table.data(), table.size(), packed.data(), packed.size()) != size)
        return malformed(0, "the index is damaged");
    return table;
}

/// Unique ids, each part's Base before its other chunks, lower layers before higher ones of the same block.
Result<void> check_order(const FileHeader& header, const std::vector<ChunkEntry>& chunks) {
    struct Place {
        ChunkId id;
        std::size_t at;
    };
    std::vector<std::size_t> base_at(header.parts.size(), chunks.size());
    std::vector<Place> places;
    places.reserve(chunks.size());
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        const ChunkId& id = chunks[i].id;
        if (id.channel == Channel::Base)
            base_at[id.part] = std::min(base_at[id.part], i);
        else if (base_at[id.part] == chunks.size())
            return malformed(0, "a chunk comes before its part's base");
        places.push_back({id, i});
    }
    const auto block = [](const ChunkId& id) { return ChunkId{id.part, id.tile, id.level, 0, id.channel}; };
    std::sort(places.begin(), places.end(), [&](const Place& a, const Place& b) {
        const auto order = block(a.id) <=> block(b.id);
        return order != 0 ? order < 0 : a.id.layer != b.id.layer ? a.id.layer < b.id.layer : a.at < b.at;
    });
    for (std::size_t i = 1; i < places.size(); ++i) {
        if (places[i].id == places[i - 1].id) return malformed(0, "two chunks have the same id");
        if (block(places[i].id) == block(places[i - 1].id) && places[i].at < places[i - 1].at)
            return malformed(0, "a chunk comes before a lower layer of its block");
    }
    return {};
}

}  // namespace

Result<Toc> read_toc(const FileHeader& header, ByteSpan index, std::uint64_t file_bytes, const Limits& limits) {
    if (header.file_bytes() != file_bytes)
        return malformed(header.index_offset, "the file has " + std::to_string(file_bytes) +
                                                  " bytes, its header says " + std::to_string(header.file_bytes()));
    if (index.size() != header.index_bytes) return malformed(header.index_offset, "the index is incomplete");
    const Result<Bytes> table = unpack_index(index, file_bytes);
    if (!table.ok()) return table.error();
    ByteReader in(*table);
    const std::uint64_t count = in.varint();
    if (!in.ok()) return malformed(header.index_offset, "the index is empty");
    if (count > limits.max_chunks) return over_limit(header.index_offset, "the chunk count", count, limits.max_chunks);
    if (count > in.remaining() / 3) return malformed(header.index_offset, "the index has fewer rows than it says");
    Toc toc{header, std::vector<ChunkEntry>(count)};
    std::uint64_t offset = header.header_bytes;
    ChunkId previous;
    for (ChunkEntry& c : toc.chunks) {
        const std::size_t row = in.offset();
        if (const Result<void> r = detail::read_head_fields(in, previous, limits, c.id, c.length); !r.ok())
            return r.error().code == Errc::NeedMoreData ? malformed(header.index_offset, "the index is cut")
                                                        : r.error();
        if (const Result<void> r = check_chunk_id(header, c.id); !r.ok()) return r.error();
        offset += in.offset() - row + 2;
        c.offset = offset;
        offset += c.length;
        previous = c.id;
    }
    if (offset != header.index_offset) return malformed(header.index_offset, "the chunks do not fill the file");
    for (ChunkEntry& c : toc.chunks) c.crc32c = in.u32();
    std::int64_t centibel = 0;
    for (ChunkEntry& c : toc.chunks) {
        const std::int64_t step = unzigzag(in.varint());
        if (step < -0xFFFF || step > 0xFFFF || centibel + step < 0 || centibel + step > 0xFFFF)
            return malformed(header.index_offset, "an error value is out of range");
        centibel += step;
        c.error = error_from_disk(static_cast<std::uint16_t>(centibel));
    }
    if (!in.ok() || in.remaining() != 0) return malformed(header.index_offset, "the index's rows do not fill it");
    if (const Result<void> r = check_order(header, toc.chunks); !r.ok()) return r.error();
    return toc;
}

}  // namespace mvw
