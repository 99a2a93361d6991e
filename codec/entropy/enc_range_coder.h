// Range encoder; dec_range_coder.h reads what it writes.
#pragma once
#include "codec/bytes.h"
#include "codec/entropy/range_coder.h"

namespace mvw {

class RangeEncoder {
 public:
    void encode(bool bit, std::uint32_t probability) {
        const std::uint32_t one = share_of_one(range_, probability);
        if (bit) {
            range_ = one;
        } else {
            low_ += one;
            range_ -= one;
        }
        while (range_ < kMinRange) {
            range_ <<= 8;
            shift_out();
        }
    }

    /// Ends the chunk: the fewest bytes that, with zeros assumed behind them, decode to what was encoded.
    [[nodiscard]] Bytes finish();

 private:
    /// Moves the top byte of low_ out; a run of 0xFF waits for the carry that may still turn it over.
    void shift_out() {
        if (low_ < 0xFF000000u || low_ > 0xFFFFFFFFu) {
            const auto carry = static_cast<std::uint32_t>(low_ >> 32);
            if (started_) out_.push_back(static_cast<std::byte>(held_ + carry));
            for (; waiting_ > 0; --waiting_) out_.push_back(static_cast<std::byte>(0xFF + carry));
            held_ = static_cast<std::uint8_t>(low_ >> 24);
            started_ = true;
        } else {
            ++waiting_;
        }
        low_ = (low_ & 0x00FFFFFFu) << 8;
    }

    Bytes out_;
    std::uint64_t low_ = 0;  // 33 bits: the top one is a carry into what was shifted out
    std::uint32_t range_ = 0xFFFFFFFFu;
    std::uint64_t waiting_ = 0;
    std::uint8_t held_ = 0;
    bool started_ = false;
};

}  // namespace mvw
