// One bit-plane of one block: which binary decisions are coded, in which order, in which contexts. Encoder and decoder
// run this same code, one with the truth at hand, the other with the answers of the range decoder. Integers only.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/entropy/block.h"
#include "codec/entropy/range_coder.h"

namespace mvw {

inline constexpr unsigned kMaxComponents = 4;
inline constexpr unsigned kMaxPlanes = 31;  // magnitudes are below 2^31

/// Probability of a 1 that follows what was coded in its context: the mean of a quick and a slow estimate.
class AdaptiveBit {
 public:
    [[nodiscard]] std::uint32_t probability() const {
        const std::uint32_t mean = (std::uint32_t{quick_} + slow_) / 2;
        return std::clamp<std::uint32_t>(mean, kMinProbability, (1u << kProbabilityBits) - kMinProbability);
    }
    void learn(bool bit) {
        quick_ = moved(quick_, bit, 4);
        slow_ = moved(slow_, bit, 7);
    }

 private:
    static std::uint16_t moved(std::uint16_t p, bool bit, unsigned rate) {
        return static_cast<std::uint16_t>(bit ? p + ((0xFFFFu - p) >> rate) : p - (p >> rate));
    }
    std::uint16_t quick_ = 1u << 15, slow_ = 1u << 15;
};

/// The coefficients as known so far, coefficient-major (coefficient i, component c at i * components + c): magnitude
/// with the planes not yet coded zero, doubled, plus 1 where negative.
using Magnitudes = std::vector<std::uint32_t>;
constexpr std::uint32_t magnitude_of(std::uint32_t entry) {
    return entry >> 1;
}

/// Adaptive state of a block across its planes.
class PlaneModel {
 public:
    static constexpr unsigned kNeighborClasses = 6, kParentClasses = 3, kSiblingClasses = 3;

    AdaptiveBit& significance(unsigned component, unsigned neighbors, unsigned parent, unsigned siblings) {
        return significance_[((component * kNeighborClasses + neighbors) * kParentClasses + parent) * kSiblingClasses +
                             siblings];
    }
    AdaptiveBit& refinement(unsigned component, bool first) { return refinement_[component * 2 + first]; }

 private:
    std::array<AdaptiveBit, kMaxComponents * kNeighborClasses * kParentClasses * kSiblingClasses> significance_{};
    std::array<AdaptiveBit, kMaxComponents * 2> refinement_{};
};

/// Codes plane `plane` of a block. Coder has `bool code(AdaptiveBit&, Truth)`-like calls below and `stopped()`.
/// Returns how many entries were completed: all of them, unless the coder stopped.
///
/// entries: the block's, planes above `plane` coded. parent: the entries of the block one level below with at least the
/// planes above `plane`, or empty: then parents count as zero.
template <typename Coder>
std::size_t code_plane(const BlockShape& shape, unsigned components, unsigned plane, PlaneModel& model,
                       std::span<const std::uint32_t> parent, std::span<std::uint32_t> entries, Coder& coder) {
    const auto capped = [](std::uint32_t x, std::uint32_t cap) { return x < cap ? x : cap; };
    const bool has_parents = !parent.empty() && !shape.parents().empty();
    for (std::size_t i = 0; i < shape.size(); ++i) {
        const BlockShape::Neighbors& near = shape.neighbors()[i];
        std::uint32_t siblings = 0;
        for (unsigned c = 0; c < components; ++c) {
            const std::size_t at = i * components + c;
            std::uint32_t& entry = entries[at];
            if (magnitude_of(entry) != 0) {
                const bool first = (magnitude_of(entry) >> (plane + 1)) == 1;
                const bool bit = coder.code(model.refinement(c, first), at, plane);
                if (coder.stopped()) return at;
                entry |= std::uint32_t{bit} << (plane + 1);
                ++siblings;
                continue;
            }
            std::uint32_t around = 0, above = 0;
            for (const std::uint32_t k : near)
                if (k != kNone) around += capped(magnitude_of(entries[k * components + c]) >> plane, 4);
            if (has_parents)
                for (const std::uint32_t k : shape.parents()[i])
                    if (k != kNone) above += capped(magnitude_of(parent[k * components + c]) >> (plane + 1), 2);
            AdaptiveBit& bit = model.significance(c, capped(around, PlaneModel::kNeighborClasses - 1),
                                                  capped(above, PlaneModel::kParentClasses - 1),
                                                  capped(siblings, PlaneModel::kSiblingClasses - 1));
            const bool significant = coder.code(bit, at, plane);
            if (coder.stopped()) return at;
            if (!significant) continue;
            const bool negative = coder.code_sign(at);
            if (coder.stopped()) return at;
            entry = (2u << plane) | std::uint32_t{negative};
            ++siblings;
        }
    }
    return entries.size();
}

}  // namespace mvw
