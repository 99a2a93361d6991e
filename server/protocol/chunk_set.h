// A set of chunks, named by their place in file order: what a peer holds, or has been sent. Neighbours merge into
// ranges, so a set costs a few bytes however many chunks it names.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "codec/bytes.h"
#include "codec/result.h"

namespace mvw::protocol {

/// Ordered set of chunk indices as maximal disjoint ranges.
class ChunkSet {
 public:
    /// Chunks first .. last, both included.
    struct Range {
        std::uint32_t first = 0, last = 0;
        friend constexpr bool operator==(const Range&, const Range&) = default;
    };

    /// O(log R), and O(R) where a range opens or closes.
    void insert(std::uint32_t index);
    /// Adds all of another set. O(R + S).
    void merge(const ChunkSet& other);
    void clear() { ranges_.clear(); }
    [[nodiscard]] bool contains(std::uint32_t index) const;
    [[nodiscard]] bool empty() const { return ranges_.empty(); }
    [[nodiscard]] std::uint64_t count() const;
    [[nodiscard]] std::span<const Range> ranges() const { return ranges_; }

    /// On the wire (PROTOCOL.md 5): varint number of ranges, then for each varint (first - end of the one before) and
    /// varint (last - first). The first range's gap counts from 0, every other from two past the one before, so that
    /// one set has one spelling.
    void write(ByteWriter& out) const;
    /// Malformed where a range leaves 32 bits or the count is more than the bytes present can hold.
    static Result<ChunkSet> read(ByteReader& in);

    friend bool operator==(const ChunkSet&, const ChunkSet&) = default;

 private:
    std::vector<Range> ranges_;
};

}  // namespace mvw::protocol
