#include "codec/entropy/enc_range_coder.h"

namespace mvw {

Bytes RangeEncoder::finish() {
    // Any number in [low, low + range) will do: take the one with the most zero bits at its end, then drop zero bytes,
    // because the decoder reads zeros past the end.
    const std::uint64_t top = low_ + range_ - 1;
    for (unsigned bits = 33; bits-- > 0;) {
        const std::uint64_t rounded = (top >> bits) << bits;
        if (rounded < low_) continue;
        low_ = rounded;
        break;
    }
    for (int k = 0; k < 5; ++k) shift_out();
    while (!out_.empty() && out_.back() == std::byte{0}) out_.pop_back();
    return std::move(out_);
}

}  // namespace mvw
