// Header and table of contents of a .mvw file: all that a server reads of it. FORMAT.md 2 and 5 are normative.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/container/chunk.h"

namespace mvw {

inline constexpr std::uint16_t kFormatVersion = 10;
inline constexpr std::uint32_t kKnownFeatures = 0;  // required-feature bits that this build knows

/// One part of the model: wavelet parts carry levels >= 1; a part of level 0 alone is a mesh coded as it is.
struct PartInfo {
    std::uint8_t levels = 0;  // L
    std::uint32_t base_vertices = 0, base_edges = 0, base_faces = 0;
    std::uint16_t tiles = 1;
    std::uint8_t first_tiled_level = 0;  // levels below have one tile, numbered 0; 0 where tiles is 1
    /// The last part of several may be all of the model as plain triangles, of level 0, finer than those before: once
    /// its base has come, it stands for all other parts.
    bool supersedes = false;
    /// The part before that, of several, may be all of the model as few plain triangles: it is shown until the others'
    /// bases are there and they state a smaller error than it does.
    bool preview = false;
    /// A file's only part, of level 0, or a preview may be progressive: its Base holds a coarse version, chunks of
    /// splits lead to the counts above, planes follow.
    bool progressive = false;
    /// Whether there are coefficients.
    [[nodiscard]] bool has_planes() const { return levels > 0 || supersedes || progressive; }
    friend bool operator==(const PartInfo&, const PartInfo&) = default;
};

/// What the first bytes of a file say.
struct FileHeader {
    std::uint16_t version = kFormatVersion;
    std::uint32_t features = 0;                 // required-feature bits; an unknown one means refuse
    std::array<std::uint8_t, 16> content_id{};  // 128-bit hash of header and payloads: ETag and cache key
    std::array<double, 3> center{};             // of the box, roughly; positions are coded as (p - center) / diagonal
    double diagonal = 1;                        // of the box, up to 2^-15 longer
    std::uint8_t transform = 0;                 // TransformKind
    std::uint8_t layers = 0;                    // chunks' layers are below this
    std::vector<PartInfo> parts;
    std::uint32_t header_bytes = 0;  // the header's own size, metadata included: where the first chunk's head is
    std::uint64_t index_offset = 0;  // where the last payload ends
    std::uint32_t index_bytes = 0;
    Bytes metadata;  // decoder parameters beyond the above, opaque to the server

    [[nodiscard]] std::uint64_t file_bytes() const { return index_offset + index_bytes; }
    /// The first so many make up the model together; those behind stand for all of it.
    [[nodiscard]] std::size_t main_parts() const {
        std::size_t count = parts.size();
        while (count > 0 && (parts[count - 1].supersedes || parts[count - 1].preview)) --count;
        return count;
    }
};

/// Header and chunks in file order.
struct Toc {
    FileHeader header;
    std::vector<ChunkEntry> chunks;
};

/// Parses the header at the start of a file. NeedMoreData until all of it is there; Unsupported, Malformed,
/// LimitExceeded as they say.
Result<FileHeader> read_header(ByteSpan prefix, const Limits& limits = {});

/// Parses the index (the index_bytes at index_offset) and checks it against the file's size: offsets rise, chunks do
/// not overlap, ids are unique and in range, a part's Base comes before its other chunks and lower layers before
/// higher ones.
Result<Toc> read_toc(const FileHeader& header, ByteSpan index, std::uint64_t file_bytes, const Limits& limits = {});

/// How many of a file's chunks it takes until something of all of the model is shown: the preview's base, or the bases
/// of all main parts.
std::size_t chunks_until_shown(const Toc& toc);

/// Malformed where an id names a part, tile, level or layer that the header does not have.
Result<void> check_chunk_id(const FileHeader& header, const ChunkId& id);

/// Finest level of all parts.
unsigned finest_level(const FileHeader& header);
/// Whether a view of layers up to `layer` is made of this chunk, too: all of their layers and all bases are, but
/// nothing of a closing part unless no layer is left out.
bool in_layers(const FileHeader& header, const ChunkId& id, unsigned layer);

/// Error values on disk are hundredths of a decibel (FORMAT.md 5): 20 log10(1/error), rounded; 65535 stands for 0.
std::uint16_t error_to_disk(double error);
float error_from_disk(std::uint16_t centibel);

}  // namespace mvw
