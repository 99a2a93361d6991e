#include "codec/entropy/dec_block.h"

#include <algorithm>
#include <bit>
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

Error out_of_turn(unsigned plane) {
    return {Errc::Malformed, 0, "bit-plane " + std::to_string(plane) + " does not follow those before it"};
}

/// sign * (magnitude + middle) * scale, or zero; no branch hangs on the entry.
float value_of(std::uint32_t entry, float middle, float scale) {
    const float value = (static_cast<float>(static_cast<std::int32_t>(magnitude_of(entry))) + middle) * scale;
    return std::bit_cast<float>((std::bit_cast<std::uint32_t>(value) ^ (entry << 31)) &
                                (0u - std::uint32_t{entry != 0}));
}

/// The fast profile's. kCount: the components where that is known beforehand, else 0.
template <unsigned kCount>
void values_of(std::span<const std::uint32_t> entries, std::size_t size, std::size_t first, float middle,
               std::span<const float> scale, std::span<float> out) {
    const std::size_t count = kCount == 0 ? scale.size() : kCount, wanted = out.size() / count;
    const std::uint32_t* const from = entries.data() + first;
    for (std::size_t i = 0; i < wanted; ++i)
        for (std::size_t c = 0; c < count; ++c) out[i * count + c] = value_of(from[c * size + i], middle, scale[c]);
}

}  // namespace

bool BlockDecoder::follows(unsigned plane) const {
    return started() ? plane + 1 == plane_ && complete_ == size_ * components_ : plane < kMaxPlanes;
}

Result<void> BlockDecoder::decode_plane(const BlockShape& shape, const BlockDecoder* parent, unsigned plane,
                                        ByteSpan bytes, bool whole) {
    if (!follows(plane) || !unpacked_.empty()) return out_of_turn(plane);
    if (!started()) {
        size_ = shape.size();
        progress_ = std::make_unique<BlockProgress>(size_, components_);
        progress_->top = plane;
    }
    plane_ = plane;
    std::span<const EntryRow> above;
    if (parent != nullptr && parent->progress_) above = parent->progress_->rows;
    complete_ = whole ? decode_whole(shape, above, plane, bytes, *progress_)
                      : decode<true>(shape, above, plane, bytes, *progress_);
    return {};
}

Result<void> BlockDecoder::unpack(std::size_t size, unsigned top, unsigned low, ByteSpan raw) {
    if (!follows(top) || low > top || progress_) return out_of_turn(top);
    if (raw.size() != size * components_ * packed_width(top, low))
        return Error{Errc::Malformed, 0, "packed planes are not of the block's size"};
    size_ = size;
    complete_ = size * components_;
    plane_ = low;
    unpacked_.resize(complete_);
    unpack_planes(raw, top, low, unpacked_);
    return {};
}

void BlockDecoder::values(float reconstruction, std::span<const float> scale, std::size_t first,
                          std::span<float> out) const {
    if (!started()) return std::fill(out.begin(), out.end(), 0.0f);
    assert(scale.size() == components_ && out.size() % components_ == 0 && first + out.size() / components_ <= size_);
    const float here = std::ldexp(reconstruction, static_cast<int>(plane_)), behind = 2 * here;
    if (!progress_ && !kSmall && components_ == 3) return values_of<3>(unpacked_, size_, first, here, scale, out);
    if (!progress_ && !kSmall) return values_of<0>(unpacked_, size_, first, here, scale, out);
    for (std::size_t at = 0, i = first; at < out.size(); ++i)
        for (unsigned c = 0; c < components_; ++c, ++at)
            out[at] = value_of(entry(i, c), i * components_ + c < complete_ ? here : behind, scale[c]);
}

std::uint32_t BlockDecoder::entry(std::size_t coefficient, unsigned component) const {
    return progress_ ? progress_->rows[coefficient].of[component] : unpacked_[component * size_ + coefficient];
}

void BlockDecoder::integers(std::span<std::int32_t> out) const {
    if (!started()) return std::fill(out.begin(), out.end(), 0);
    assert(out.size() == size_ * components_);
    for (std::size_t at = 0; at < out.size(); ++at) {
        const std::uint32_t of = entry(at / components_, static_cast<unsigned>(at % components_));
        const auto magnitude = static_cast<std::int32_t>(magnitude_of(of));
        out[at] = (of & 1u) != 0 ? -magnitude : magnitude;
    }
}

}  // namespace mvw
