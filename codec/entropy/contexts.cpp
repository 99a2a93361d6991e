#include "codec/entropy/contexts.h"

#include "codec/entropy/priors.h"

namespace mvw {

namespace {

constexpr auto states_of(const std::array<std::int8_t, BlockModel::kBits>& logits) {
    std::array<AdaptiveBit, BlockModel::kBits> bits{};
    for (std::size_t k = 0; k < bits.size(); ++k) bits[k] = AdaptiveBit(logits[k]);
    return bits;
}

/// Trained weights are in 1/64.
constexpr auto states_of(const std::array<std::int8_t, 2 * BlockModel::kWeights>& trained) {
    std::array<MixWeights, BlockModel::kWeights> weights{};
    for (std::size_t k = 0; k < weights.size(); ++k)
        weights[k].weight = {trained[2 * k] * 1024, trained[2 * k + 1] * 1024};
    return weights;
}

constexpr auto kTrainedBitStates = states_of(kTrainedLogits);
constexpr auto kTrainedWeightStates = states_of(kTrainedWeights);

}  // namespace

BlockModel::BlockModel() : bits_(kTrainedBitStates), weights_(kTrainedWeightStates) {}

BlockModel::BlockModel(const std::array<std::int8_t, kBits>& logits,
                       const std::array<std::int8_t, 2 * kWeights>& weights)
    : bits_(states_of(logits)), weights_(states_of(weights)) {}

}  // namespace mvw
