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
std::size_t decode(const BlockShape& shape, std::span<const EntryRow> parent, unsigned plane, ByteSpan bytes,
                   BlockProgress& progress) {
    PlaneReader<kCut> reader(bytes);
    return PlaneCoder(shape, parent, plane, progress, reader).run();
}

#if !defined(__EMSCRIPTEN__)  // there what counts is the module's size
[[gnu::flatten]]
#endif
/// All in one function: then the range coder's state stays in registers.
std::size_t
decode_whole(const BlockShape& shape, std::span<const EntryRow> parent, unsigned plane, ByteSpan bytes,
             BlockProgress& progress) {
    return decode<false>(shape, parent, plane, bytes, progress);
}

}  // namespace

Result<void> BlockDecoder::decode_plane(const BlockShape& shape, const BlockDecoder* parent, unsigned plane,
                                        ByteSpan bytes, bool whole) {
    const bool follows =
        started() ? plane + 1 == plane_ && complete_ == shape.size() * components_ : plane < kMaxPlanes;
    if (!follows)
        return Error{Errc::Malformed, 0, "bit-plane " + std::to_string(plane) + " does not follow those before it"};
    start(shape.size(), plane);
    plane_ = plane;
    std::span<const EntryRow> above;
    if (parent != nullptr && parent->started()) above = parent->progress_->rows;
    complete_ = whole ? decode_whole(shape, above, plane, bytes, *progress_)
                      : decode<true>(shape, above, plane, bytes, *progress_);
    return {};
}

void BlockDecoder::start(std::size_t size, unsigned top) {
    if (started()) return;
    progress_ = std::make_unique<BlockProgress>(size, components_);
    progress_->top = top;
}

Result<void> BlockDecoder::unpack(std::size_t size, unsigned top, unsigned low, ByteSpan packed) {
    if (top >= kMaxPlanes || low > top || (started() && top + 1 != plane_))
        return Error{Errc::Malformed, 0, "bit-plane " + std::to_string(top) + " does not follow those before it"};
    Bytes raw;
    if (!unzip_planes(packed, size * components_, top, low, raw))
        return Error{Errc::Malformed, 0, "packed planes are damaged"};
    start(size, top);
    unpack_planes(raw, components_, top, low, std::span(progress_->rows).first(size));
    plane_ = low;
    complete_ = size * components_;
    return {};
}

void BlockDecoder::values(float reconstruction, std::span<float> out) const {
    if (!started()) return std::fill(out.begin(), out.end(), 0.0f);
    assert(out.size() == (progress_->rows.size() - 1) * components_);
    const float here = std::ldexp(reconstruction, static_cast<int>(plane_)), behind = 2 * here;
    std::size_t at = 0;
    for (const EntryRow* row = progress_->rows.data(); at < out.size(); ++row)
        for (unsigned c = 0; c < components_; ++c, ++at) {
            const std::uint32_t entry = row->of[c];
            const float magnitude = static_cast<float>(magnitude_of(entry)) + (at < complete_ ? here : behind);
            out[at] = entry == 0 ? 0.0f : (entry & 1u) != 0 ? -magnitude : magnitude;
        }
}

void BlockDecoder::integers(std::span<std::int32_t> out) const {
    if (!started()) return std::fill(out.begin(), out.end(), 0);
    assert(out.size() == (progress_->rows.size() - 1) * components_);
    for (std::size_t at = 0; at < out.size(); ++at) {
        const std::uint32_t entry = progress_->rows[at / components_].of[at % components_];
        const auto magnitude = static_cast<std::int32_t>(magnitude_of(entry));
        out[at] = (entry & 1u) != 0 ? -magnitude : magnitude;
    }
}

}  // namespace mvw
