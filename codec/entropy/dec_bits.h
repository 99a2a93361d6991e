// The bits of a range-coded string, for coders that encoder and decoder share (model_coder.h).
#pragma once
#include "codec/entropy/dec_range_coder.h"

namespace mvw {

class DecodedBits {
 public:
    using Bits = DecodedBits;
    /// whole: else the bytes are the beginning of a string. They outlive this.
    explicit DecodedBits(ByteSpan bytes, bool whole = true) : decoder_(bytes, whole) {}

    bool code(std::uint32_t probability, bool) { return decoder_.decode(probability); }
    /// Whether the last bit is not known.
    [[nodiscard]] bool stopped() const { return decoder_.stopped(); }

 private:
    RangeDecoder<true> decoder_;
};

}  // namespace mvw
