// Range decoder over a chunk that may have been cut: it knows which symbols its bytes determine.
#pragma once
#include <bit>
#include <cstring>

#include "codec/bytes.h"
#include "codec/entropy/range_coder.h"

namespace mvw {

/// kCut false: the bytes are the whole chunk, zeros stand behind them, every symbol is determined. kCut true: unknown
/// bytes stand behind them, and decode() says when they would matter. Never reads outside the span.
template <bool kCut>
class RangeDecoder {
 public:
    /// whole: kCut, but all bytes are there after all.
    explicit RangeDecoder(ByteSpan bytes, bool whole = false)
        : next_(bytes.data()), end_(bytes.data() + bytes.size()), behind_(whole ? 0 : 0xFF) {
        for (int k = 0; k < 4; ++k) shift_in();
    }

    /// The next symbol. Where stopped() turns true it was not determined, and no later one will be.
    bool decode(std::uint32_t probability) {
        const std::uint32_t one = share_of_one(range_, probability);
        const bool bit = code_ < one;
        if constexpr (kCut) {
            if (bit && unknown_ >= one - code_) stopped_ = true;
            if (stopped_) return false;
        }
        if constexpr (!kCut) {
            if (end_ - next_ >= 4) return follow(bit, one);
        }
        if (bit) {
            range_ = one;
        } else {
            code_ -= one;
            range_ -= one;
        }
        while (range_ < kMinRange) {
            range_ <<= 8;
            shift_in();
        }
        return bit;
    }
    [[nodiscard]] bool stopped() const { return stopped_; }

 private:
    /// The same where four bytes more are there, without a branch: none could be foreseen.
    bool follow(bool bit, std::uint32_t one) {
        const std::uint32_t is_zero = std::uint32_t{bit} - 1u;
        code_ -= one & is_zero;
        range_ = one ^ ((one ^ (range_ - one)) & is_zero);
        const auto shift = static_cast<unsigned>(std::countl_zero(range_)) & 24u;
        std::uint32_t ahead = 0;
        std::memcpy(&ahead, next_, sizeof ahead);
        if constexpr (std::endian::native == std::endian::little) ahead = __builtin_bswap32(ahead);
        range_ <<= shift;
        code_ = code_ << shift | static_cast<std::uint32_t>(std::uint64_t{ahead} << shift >> 32);
        next_ += shift / 8;
        return bit;
    }
    void shift_in() {
        const bool there = next_ != end_;
        code_ = (code_ << 8) | (there ? std::to_integer<std::uint32_t>(*next_++) : 0u);
        if constexpr (kCut) unknown_ = (unknown_ << 8) | (there ? 0u : behind_);
    }

    const std::byte* next_;
    const std::byte* end_;
    std::uint32_t range_ = 0xFFFFFFFFu, code_ = 0;
    std::uint32_t behind_;       // of each byte behind the end: the bits that are not known
    std::uint32_t unknown_ = 0;  // the missing bytes may add 0 to this much to code_
    bool stopped_ = false;
};

}  // namespace mvw
