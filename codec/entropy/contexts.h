// Which context each binary decision of a block is coded in, and the block's adaptive state. All features are in
// quarters of the present plane's unit, so the same statistics serve all planes, levels and steps, and one trained
// start (priors.h) serves all models.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "codec/entropy/adaptive_bit.h"

namespace mvw {

/// Eight classes of a non-negative feature, about equally wide on a logarithmic scale.
constexpr std::size_t kFeatureClasses = 8;
constexpr std::size_t feature_class(std::uint32_t x) {
    constexpr std::array<std::uint8_t, 24> kClass{0, 1, 2, 3, 3, 4, 4, 4, 5, 5, 5, 5,
                                                  5, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 7};
    return kClass[x < 23 ? x : 23];
}

/// What is known around one component of a coefficient.
struct Surroundings {
    std::uint32_t near = 0;          // magnitudes on the four sides of the two triangles, summed
    std::uint32_t far = 0;           // of the six next new points of the same direction
    std::uint32_t above = 0;         // of the parents
    std::uint32_t above_others = 0;  // of the parents' other components
    std::uint32_t siblings = 0;      // of the other components of the coefficient itself

    /// One number for all.
    [[nodiscard]] std::uint32_t activity() const { return (2 * near + far + 2 * above + siblings) / 4; }
};

/// Sums of signs, positive less negative, of the significant ones.
struct SignsAround {
    int near = 0, line = 0, far = 0, above = 0;  // within 4, 2, 4, 2 of zero
};

/// The adaptive state of a block: begins as trained, then follows its planes.
class BlockModel {
 public:
    /// A decision's two contexts and the weights that mix them; `flip` says that a context was learnt mirrored.
    struct Pair {
        AdaptiveBit *a, *b;
        MixWeights* weights;
        bool flip_a = false, flip_b = false;
    };
    static constexpr std::size_t kComponentClasses = 3;  // first, second, others

    static constexpr std::size_t kDepths = 5;
    static constexpr std::size_t kGroup = 0, kCoefficient = kGroup + kDepths * 8, kSignificance = kCoefficient + 133,
                                 kRefinement = kSignificance + 9 * 128, kSign = kRefinement + 96,
                                 kBits = kSign + kComponentClasses * 50;
    static constexpr std::size_t kCoefficientWeights = 0, kSignificanceWeights = 4, kSignWeights = 22, kWeights = 25;

    BlockModel();
    /// Another start than the trained one, in the units of priors.h: what training itself needs.
    BlockModel(const std::array<std::int8_t, kBits>& logits, const std::array<std::int8_t, 2 * kWeights>& weights);

    /// Whether anything in a quiet group (plane_coder.h) becomes significant. depth: planes since the block's top;
    /// history: the last three answers, latest in bit 0.
    AdaptiveBit& group(unsigned depth, unsigned history) {
        return bits_[kGroup + (depth < kDepths ? depth : kDepths - 1) * 8 + history];
    }
    /// Whether a coefficient with no significant component gets one. first: of component 0; others: activity of the
    /// rest; in_group: its group has just been found to have some.
    Pair coefficient(const Surroundings& first, std::uint32_t others, bool in_group) {
        const std::size_t active = feature_class(first.activity());
        MixWeights* weights = &weights_[kCoefficientWeights + active / 2];
        if (in_group && first.near + first.far + first.above == 0) {
            const std::size_t rest = feature_class(others);
            return {&bits_[kCoefficient + 128 + (rest < 3 ? rest : 3)], &bits_[kCoefficient + 132], weights};
        }
        return {&bits_[kCoefficient + active * kFeatureClasses + feature_class(others)],
                &bits_[kCoefficient + 64 + near_and_far(first)], weights};
    }
    /// Whether a component becomes significant. state: 0 where the coefficient has significant ones from higher planes,
    /// else 1 or 2: it gets one in this plane, and has got it before this component (1) or not (2).
    Pair significance(std::size_t component, const Surroundings& s, unsigned state) {
        const std::size_t c = component_class(component), active = feature_class(s.activity());
        const std::size_t set = kSignificance + (state * kComponentClasses + c) * 128;
        const std::size_t weights = state == 0 ? c * 4 + active / 2 : 12 + c * 2 + state - 1;
        return {&bits_[set + active * kFeatureClasses + feature_class(s.above_others / 4)],
                &bits_[set + 64 + near_and_far(s)], &weights_[kSignificanceWeights + weights]};
    }
    /// The next bit of a significant component; known: its magnitude in units of the plane above.
    AdaptiveBit& refinement(std::size_t component, std::uint32_t known, std::uint32_t near, std::uint32_t far) {
        const std::size_t age = known < 4 ? known - 1 : 3;
        return bits_[kRefinement + (component_class(component) * 4 + age) * kFeatureClasses +
                     feature_class((2 * near + far) / 16)];
    }
    /// Whether a component that became significant is negative. Mirrored signs share a context.
    Pair sign(std::size_t component, const SignsAround& s) {
        const std::size_t c = component_class(component);
        const bool flip_a = s.near < 0 || (s.near == 0 && s.line < 0),
                   flip_b = s.far < 0 || (s.far == 0 && s.above < 0);
        const auto index = [](int x, int y, bool flip) {
            return static_cast<std::size_t>(flip ? -x * 5 - y + 2 : x * 5 + y + 2);
        };
        return {&bits_[kSign + c * 50 + index(s.near, s.line, flip_a)],
                &bits_[kSign + c * 50 + 25 + index(s.far, s.above, flip_b)], &weights_[kSignWeights + c], flip_a,
                flip_b};
    }

    [[nodiscard]] const std::array<AdaptiveBit, kBits>& bits() const { return bits_; }
    [[nodiscard]] const std::array<MixWeights, kWeights>& weights() const { return weights_; }

 private:
    static std::size_t component_class(std::size_t c) { return c < kComponentClasses ? c : kComponentClasses - 1; }
    static std::size_t near_and_far(const Surroundings& s) {
        return feature_class(s.near / 2) * kFeatureClasses + feature_class(s.far / 2);
    }
    std::array<AdaptiveBit, kBits> bits_;
    std::array<MixWeights, kWeights> weights_;
};

}  // namespace mvw
