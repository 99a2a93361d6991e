#include "codec/entropy/dec_block.h"

#include <cassert>
#include <cmath>
#include <string>

#include "codec/entropy/dec_range_coder.h"

namespace mvw {

namespace {

/// Answers code_plane() from a chunk's bytes.
template <bool kCut>
class PlaneReader {
 public:
    explicit PlaneReader(ByteSpan bytes) : decoder_(bytes) {}

    bool code(AdaptiveBit& model, std::size_t, unsigned) {
        const bool bit = decoder_.decode(model.probability());
        model.learn(bit);
        return bit;
    }
    bool code_sign(std::size_t) { return decoder_.decode(1u << (kProbabilityBits - 1)); }
    [[nodiscard]] bool stopped() const { return kCut && decoder_.stopped(); }

 private:
    RangeDecoder<kCut> decoder_;
};

}  // namespace

Result<void> BlockDecoder::decode_plane(const BlockShape& shape, const BlockDecoder* parent, unsigned plane,
                                        ByteSpan bytes, bool whole) {
    if (plane >= plane_ || (started() && (plane + 1 != plane_ || complete_ != entries_.size())))
        return Error{Errc::Malformed, 0, "bit-plane " + std::to_string(plane) + " does not follow those before it"};
    entries_.resize(shape.size() * components_);
    plane_ = plane;
    std::span<const std::uint32_t> above;
    if (parent != nullptr) above = parent->entries_;
    if (whole) {
        PlaneReader<false> reader(bytes);
        complete_ = code_plane(shape, components_, plane, model_, above, entries_, reader);
    } else {
        PlaneReader<true> reader(bytes);
        complete_ = code_plane(shape, components_, plane, model_, above, entries_, reader);
    }
    return {};
}

void BlockDecoder::values(float reconstruction, std::span<float> out) const {
    if (!started()) return std::fill(out.begin(), out.end(), 0.0f);
    assert(out.size() == entries_.size());
    const float here = std::ldexp(reconstruction, static_cast<int>(plane_)), behind = 2 * here;
    for (std::size_t at = 0; at < out.size(); ++at) {
        const std::uint32_t entry = entries_[at];
        const float magnitude = static_cast<float>(magnitude_of(entry)) + (at < complete_ ? here : behind);
        out[at] = entry == 0 ? 0.0f : (entry & 1u) != 0 ? -magnitude : magnitude;
    }
}

void BlockDecoder::integers(std::span<std::int32_t> out) const {
    if (!started()) return std::fill(out.begin(), out.end(), 0);
    assert(out.size() == entries_.size());
    for (std::size_t at = 0; at < out.size(); ++at) {
        const auto magnitude = static_cast<std::int32_t>(magnitude_of(entries_[at]));
        out[at] = (entries_[at] & 1u) != 0 ? -magnitude : magnitude;
    }
}

}  // namespace mvw
