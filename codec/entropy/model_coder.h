// Decisions in adaptive contexts. Encoder and decoder run the same, one with the truth at hand, the other with the
// answers of the range decoder.
#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>

#include "codec/entropy/adaptive_bit.h"

namespace mvw {

/// Bits    bool code(std::uint32_t probability, bool truth): the bit, truth itself when encoding
template <typename Bits>
class ModelCoder {
 public:
    explicit ModelCoder(Bits& bits) : bits_(bits) {}

    bool code(AdaptiveBit& bit, bool truth) {
        const bool answer = bits_.code(bit.probability(), truth);
        bit.learn(answer);
        return answer;
    }
    bool code(AdaptiveBit& a, AdaptiveBit& b, MixWeights& weights, bool truth) {
        const int la = a.logit(), lb = b.logit();
        const std::uint32_t probability = logistic::probability(weights.mix(la, lb));
        const bool answer = bits_.code(probability, truth);
        weights.learn(la, lb, (static_cast<std::int32_t>(answer) << 16) - static_cast<std::int32_t>(probability));
        a.learn(answer);
        b.learn(answer);
        return answer;
    }
    std::uint32_t code_plain(std::uint32_t truth, unsigned bits) {
        std::uint32_t value = 0;
        for (unsigned k = bits; k-- > 0;)
            value = value << 1 | std::uint32_t{bits_.code(1u << (kProbabilityBits - 1), (truth >> k & 1u) != 0)};
        return value;
    }

    /// Lengths of numbers that have contexts of their own; what is longer shares the last one's.
    static constexpr std::size_t kLengths = 12;
    /// Contexts of a number, kLengths each: of its length in two ways and how these mix, of its highest bit but one.
    struct SizeContexts {
        AdaptiveBit *length, *other_length;
        MixWeights* weights;
        AdaptiveBit* top;
    };
    /// A magnitude below 2^most_length: its length in bits, its highest bit but one, the rest as it is.
    std::int64_t code_size(const SizeContexts& in, unsigned most_length, std::int64_t true_size) {
        const auto truth =
            static_cast<std::uint32_t>(std::min<std::int64_t>(true_size, (std::int64_t{1} << most_length) - 1));
        const auto true_length = static_cast<unsigned>(std::bit_width(truth));
        unsigned length = 0;
        for (bool more = true; more && length < most_length;) {
            const std::size_t k = std::min<std::size_t>(length, kLengths - 1);
            more = code(in.length[k], in.other_length[k], in.weights[k], true_length > length);
            length += more;
        }
        if (length < 2) return length;
        const bool high = code(in.top[std::min<std::size_t>(length, kLengths - 1)], (truth >> (length - 2) & 1u) != 0);
        return std::int64_t{2 + high} << (length - 2) | code_plain(truth, length - 2);
    }

 protected:
    Bits& bits_;
};

}  // namespace mvw
