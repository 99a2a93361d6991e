// A range-coded string, from coders that encoder and decoder share (model_coder.h).
#pragma once
#include <utility>

#include "codec/entropy/enc_range_coder.h"

namespace mvw {

class EncodedBits {
 public:
    using Bits = EncodedBits;

    bool code(std::uint32_t probability, bool truth) {
        encoder_.encode(truth, probability);
        return truth;
    }
    static bool stopped() { return false; }
    /// What was coded since the last time.
    Bytes take_bytes() { return std::exchange(encoder_, RangeEncoder()).finish(); }

 private:
    RangeEncoder encoder_;
};

}  // namespace mvw
