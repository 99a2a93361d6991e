// Adaptive probabilities and their mixing in the logistic domain, in integers. After M. Mahoney, Adaptive Weighing of
// Context Models (2005): each context gives ln(p/(1-p)), the code uses the squashed weighted sum, the weights learn.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "codec/entropy/range_coder.h"
#include "codec/table.h"

namespace mvw {

/// Logits are in units of 1/256, within [-2047, 2047].
inline constexpr int kMaxLogit = 2047;

namespace logistic {

/// 65536 / (1 + e^-x) at x = -8, -7.75 .. 8.
inline constexpr std::array<std::uint16_t, 65> kKnots{
    22,    28,    36,    47,    60,    77,    98,    126,   162,   208,   267,   342,   439,
    562,   720,   922,   1179,  1506,  1921,  2446,  3108,  3938,  4971,  6249,  7812,  9702,
    11955, 14595, 17625, 21025, 24743, 28693, 32768, 36843, 40793, 44511, 47911, 50941, 53581,
    55834, 57724, 59287, 60565, 61598, 62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974,
    65097, 65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514};

/// Probability in 1/65536 of a logit: linear between the knots.
constexpr std::uint32_t squash(int logit) {
    const int from_left = logit + 2048;
    const auto knot = static_cast<std::size_t>(from_left / 64);
    const int within = from_left % 64;
    return static_cast<std::uint32_t>((kKnots[knot] * (64 - within) + kKnots[knot + 1] * within) / 64);
}

constexpr auto make_probabilities() {
    std::array<std::uint16_t, 4096> table{};
    int logit = -2048;
    for (std::uint16_t& probability : table) probability = static_cast<std::uint16_t>(squash(logit++));
    return table;
}
MVW_TABLE(kProbabilities, make_probabilities());
/// squash() by table.
constexpr std::uint32_t probability(int logit) {
    const int from_left = logit + 2048;
    return kProbabilities[static_cast<std::size_t>(from_left)];
}

/// The least logit whose probability, in 1/4096, is at least the index.
constexpr auto make_logits() {
    std::array<std::int16_t, 4096> table{};
    std::size_t filled = 0;
    for (int logit = -kMaxLogit; logit <= kMaxLogit; ++logit)
        for (const std::size_t reached = squash(logit) / 16; filled <= reached; ++filled)
            table[filled] = static_cast<std::int16_t>(logit);
    for (; filled < table.size(); ++filled) table[filled] = kMaxLogit;
    return table;
}
MVW_TABLE(kLogits, make_logits());

}  // namespace logistic

/// Estimates the probability of a 1 from the bits seen in one context: their running mean at first, later one that
/// forgets with a time constant of kLimit bits.
class AdaptiveBit {
 public:
    static constexpr std::uint32_t kLimit = 250;
    /// How many bits a trained start counts for.
    static constexpr std::uint32_t kTrainedCount = 14;

    constexpr AdaptiveBit() = default;
    /// A trained start (priors.h): the logit in units of 1/16, or kUntrained.
    static constexpr int kUntrained = -128;
    explicit constexpr AdaptiveBit(int trained)
        : state_(trained == kUntrained ? kHalf : logistic::squash(trained * 16) << 16 | kTrainedCount) {}

    /// Of a 1, as the range coder wants it.
    [[nodiscard]] std::uint32_t probability() const {
        return std::clamp(state_ >> 16, kMinProbability, (1u << kProbabilityBits) - kMinProbability);
    }
    [[nodiscard]] int logit() const { return logistic::kLogits[state_ >> 20]; }
    [[nodiscard]] std::uint32_t count() const { return state_ & 1023u; }
    void learn(bool bit) {
        // The way to 2^22 - 1 or to 0, as its length and a sign: no branch hangs on the bit.
        const std::uint32_t seen = count(), towards_one = 0u - std::uint32_t{bit};
        const std::uint64_t way = (state_ ^ towards_one) >> 10;
        const auto part = static_cast<std::uint32_t>(way * static_cast<std::uint32_t>(kGain[seen]) >> 16) << 10;
        state_ += (part ^ ~towards_one) - ~towards_one;
        state_ += seen < kLimit;
    }

 private:
    /// 65536 / (n + 1.5): how far the n-th bit moves the mean.
    static constexpr auto kGain = [] {
        std::array<std::int32_t, kLimit + 1> gain{};
        for (std::size_t n = 0; n < gain.size(); ++n) gain[n] = static_cast<std::int32_t>(131072 / (2 * n + 3));
        return gain;
    }();
    static constexpr std::uint32_t kHalf = 1u << 31;
    std::uint32_t state_ = kHalf;  // probability in 2^-22, above the count of bits seen in the low 10 bits
};

/// Weights of two logits, in 1/65536. They learn slowly, in the direction that would have made the bit likelier.
struct MixWeights {
    std::array<std::int32_t, 2> weight{};

    [[nodiscard]] int mix(int a, int b) const {
        return std::clamp((weight[0] * a + weight[1] * b) / 65536, -kMaxLogit, kMaxLogit);  // below 2^31: kLimit
    }
    /// error: 65536 * bit - probability.
    void learn(int a, int b, std::int32_t error) {
        weight[0] = moved(weight[0], a, error);
        weight[1] = moved(weight[1], b, error);
    }

 private:
    static constexpr std::int32_t kLimit = 4 << 16;
    static std::int32_t moved(std::int32_t weight, int logit, std::int32_t error) {
        return std::clamp(weight + logit * error / 65536, -kLimit, kLimit);
    }
};

}  // namespace mvw
