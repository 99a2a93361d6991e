#include "codec/entropy/dec_block.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include "codec/entropy/dec_range_coder.h"
#include "codec/entropy/packed_planes.h"

namespace mvw {

namespace {

/// Answers a PlaneCoder from a chunk's bytes.
template <bool kCut>
class PlaneReader {
 public:
    explicit PlaneReader(ByteSpan bytes) : decoder_(bytes) {}

    bool code(std::uint32_t probability, bool) { return decoder_.decode(probability); }
    static constexpr bool any(std::size_t, std::size_t, unsigned) { return false; }
    static constexpr std::uint32_t truth(std::size_t) { return 0; }
    [[nodiscard]] bool stopped() const { return kCut && decoder_.stopped(); }

 private:
    RangeDecoder<kCut> decoder_;
};

template <bool kCut>
std::size_t decode(const BlockShape& shape, std::span<const std::uint32_t> parent, unsigned plane, ByteSpan bytes,
                   BlockProgress& progress) {
    PlaneReader<kCut> reader(bytes);
    return PlaneCoder(shape, parent, plane, progress, reader).run();
}

}  // namespace

Result<void> BlockDecoder::decode_plane(const BlockShape& shape, const BlockDecoder* parent, unsigned plane,
                                        ByteSpan bytes, bool whole) {
    const bool follows = started() ? plane + 1 == plane_ && complete_ == progress_->entries.size() : plane < kMaxPlanes;
    if (!follows)
        return Error{Errc::Malformed, 0, "bit-plane " + std::to_string(plane) + " does not follow those before it"};
    start(shape, plane);
    plane_ = plane;
    std::span<const std::uint32_t> above;
    if (parent != nullptr && parent->started()) above = parent->progress_->entries;
    complete_ = whole ? decode<false>(shape, above, plane, bytes, *progress_)
                      : decode<true>(shape, above, plane, bytes, *progress_);
    return {};
}

void BlockDecoder::start(const BlockShape& shape, unsigned top) {
    if (started()) return;
    progress_ = std::make_unique<BlockProgress>(shape.size(), components_);
    progress_->top = top;
}

Result<void> BlockDecoder::unpack(const BlockShape& shape, unsigned top, unsigned low, ByteSpan packed) {
    if (top >= kMaxPlanes || low > top || (started() && top + 1 != plane_))
        return Error{Errc::Malformed, 0, "bit-plane " + std::to_string(top) + " does not follow those before it"};
    Entries entries = started() ? progress_->entries : Entries(shape.size() * components_);
    if (!unpack_planes(packed, components_, top, low, entries))
        return Error{Errc::Malformed, 0, "packed planes are damaged"};
    start(shape, top);
    progress_->entries = std::move(entries);
    plane_ = low;
    complete_ = progress_->entries.size();
    return {};
}

void BlockDecoder::values(float reconstruction, std::span<float> out) const {
    if (!started()) return std::fill(out.begin(), out.end(), 0.0f);
    assert(out.size() == progress_->entries.size());
    const float here = std::ldexp(reconstruction, static_cast<int>(plane_)), behind = 2 * here;
    for (std::size_t at = 0; at < out.size(); ++at) {
        const std::uint32_t entry = progress_->entries[at];
        const float magnitude = static_cast<float>(magnitude_of(entry)) + (at < complete_ ? here : behind);
        out[at] = entry == 0 ? 0.0f : (entry & 1u) != 0 ? -magnitude : magnitude;
    }
}

void BlockDecoder::integers(std::span<std::int32_t> out) const {
    if (!started()) return std::fill(out.begin(), out.end(), 0);
    assert(out.size() == progress_->entries.size());
    for (std::size_t at = 0; at < out.size(); ++at) {
        const auto magnitude = static_cast<std::int32_t>(magnitude_of(progress_->entries[at]));
        out[at] = (progress_->entries[at] & 1u) != 0 ? -magnitude : magnitude;
    }
}

}  // namespace mvw
