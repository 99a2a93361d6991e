// Decodes the bit-planes of one block, as far as they have come.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codec/bytes.h"
#include "codec/entropy/plane_coder.h"
#include "codec/result.h"

namespace mvw {

/// A block's coefficients as far as its planes have come. Before the first plane it has allocated nothing.
class BlockDecoder {
 public:
    /// components: 1 to kMaxComponents.
    explicit BlockDecoder(unsigned components) : components_(components) {}

    /// Decodes the next plane down; the first call sets the top plane. shape: the same one each time. parent: the block
    /// of the same tile and channel one level below (null at levels 0 and 1), all of whose planes above `plane` must
    /// have been decoded whole; lower ones do no harm. whole: false where `bytes` is a cut-off beginning of the plane:
    /// then as many coefficients are updated as the bytes determine, and no plane can follow.
    ///
    /// Malformed where the plane is not the next one down (or is above kMaxPlanes - 1), or a cut plane came before.
    /// Any bytes decode to something: a checksum is the caller's. O(size), independent of the bytes.
    Result<void> decode_plane(const BlockShape& shape, const BlockDecoder* parent, unsigned plane, ByteSpan bytes,
                              bool whole);

    /// The fast profile's way to the planes from `top`, the next one down (or the first), to `low`. size: the block's.
    /// raw: what unzip_planes() gave for as many entries. Malformed as for decode_plane(), where raw is of another size,
    /// and where planes came the other way before.
    Result<void> unpack(std::size_t size, unsigned top, unsigned low, ByteSpan raw);

    [[nodiscard]] unsigned components() const { return components_; }
    /// False while all coefficients are zero because no plane has come.
    [[nodiscard]] bool started() const { return plane_ < kMaxPlanes; }
    /// Lowest plane of which anything is known; kMaxPlanes before the first.
    [[nodiscard]] unsigned lowest_plane() const { return plane_; }

    /// Coefficients from number `first` on, coefficient-major, as many as out.size() / components, each component times
    /// its scale: zero, or the middle of what the decoded planes leave open, sign * (magnitude + reconstruction *
    /// 2^(lowest plane known of this coefficient)).
    void values(float reconstruction, std::span<const float> scale, std::size_t first, std::span<float> out) const;
    /// Exact integers, for lossless coding: right once plane 0 has come whole.
    void integers(std::span<std::int32_t> out) const;

 private:
    [[nodiscard]] bool follows(unsigned plane) const;
    [[nodiscard]] std::uint32_t entry(std::size_t coefficient, unsigned component) const;

    unsigned components_;
    unsigned plane_ = kMaxPlanes;
    std::size_t size_ = 0;                     // coefficients
    std::size_t complete_ = 0;                 // entries that have plane_; those behind stand at plane_ + 1
    std::unique_ptr<BlockProgress> progress_;  // some kilobytes: a file may name many blocks and fill few
    std::vector<std::uint32_t> unpacked_;      // instead, in the fast profile: entries, component-major
};

}  // namespace mvw
