// From bytes to meshes, progressively. Decoding never needs the encoder's rooms or exceptions, and no threads.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "codec/container/toc.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// What a decoder holds at a moment.
struct DecodeState {
    std::uint64_t bytes = 0;   // header and chunks taken in
    unsigned level = 0;        // finest level for which any detail has arrived (or the file's last where all have, or
                               // a closing part's base has)
    float error = 1;           // RMS surface error left as the file states it, fraction of the diagonal; with expect(),
                               // that of the chunks in file order before the first that is missing or damaged
    std::uint32_t chunks = 0;  // taken in
    std::uint32_t damaged = 0;  // chunks whose checksum or heads were wrong: skipped
    std::uint32_t waiting = 0;  // taken in, but of use only once others come
    bool complete = false;      // all of the file is there: known from its bytes in order, or after expect()
};

/// Push decoder: feed a file's bytes in order (any slices), or a header and chunks in any useful order; take the best
/// mesh so far at any time.
class Decoder {
 public:
    /// threads: that decode side by side once a mesh is asked for. The mesh does not depend on them.
    explicit Decoder(const Limits& limits = {}, unsigned threads = 1);
    ~Decoder();
    Decoder(Decoder&&) noexcept;
    Decoder& operator=(Decoder&&) noexcept;

    /// The next bytes of the file. A wrong checksum skips that chunk and is counted; an error means that nothing more
    /// can be made of these bytes (what was taken in stays usable).
    Result<void> feed(ByteSpan bytes);
    /// No more bytes will come: uses what a cut chunk still holds. Afterwards only mesh() and state() are useful.
    void finish();

    /// The file's header (header_bytes at its start), for transports that carry chunks one by one.
    Result<void> feed_header(ByteSpan bytes);
    /// One chunk's payload, checked against crc32c. Chunks that come before their lower layers wait inside.
    Result<void> feed_chunk(const ChunkId& id, ByteSpan payload, std::uint32_t crc32c);
    /// The file's table, before its chunks: what state() then holds the chunks that feed_chunk() gets against.
    void expect(std::span<const ChunkEntry> chunks);
    /// Header and chunks of a file that is whole, found through its index, so that damage costs no more than what is
    /// damaged; only those chunks that `wanted` takes, or all. False where the file is cut or its index damaged: then
    /// nothing was fed, and feed() is the way.
    bool feed_file(ByteSpan file, const std::function<bool(const ChunkEntry&)>& wanted = {});

    [[nodiscard]] const FileHeader* header() const;  // null until it is there
    [[nodiscard]] DecodeState state() const;
    /// Changes whenever mesh() would differ.
    [[nodiscard]] std::uint64_t revision() const;
    /// The best mesh of what has come: every part that shows() at min(level, its own finest). NeedMoreData until a base
    /// mesh is there.
    [[nodiscard]] Result<Mesh> mesh(unsigned level = 255) const;

    /// Whether mesh(level) holds one of the header's parts: those whose bases are there, but where one stands for all
    /// (PartInfo::supersedes), either this, for levels above all others', or the others, before which there may be a
    /// preview (PartInfo::preview).
    [[nodiscard]] bool shows(std::size_t part, unsigned level) const;
    /// Connectivity of level 0 of one of the header's parts; null until its base is there. Of a progressive part it has
    /// fewer vertices than the header says until all splits are there. mesh() holds the parts that
    /// it shows in the header's order, each with V(l) vertices and its faces as in triangles_at_level(base, l), where
    /// l is min(level, finest_level(part)).
    [[nodiscard]] const BaseMesh* base(std::size_t part) const;
    [[nodiscard]] unsigned finest_level(std::size_t part) const;
    /// FNV-1a over the bits of all coefficients (positions, attributes) decoded so far: the same on every platform for
    /// the same chunks.
    [[nodiscard]] std::uint64_t coefficient_digest() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Decodes a whole file or any prefix of one in one go.
Result<Mesh> decode(ByteSpan file, unsigned level = 255, const Limits& limits = {}, unsigned threads = 1);

}  // namespace mvw
