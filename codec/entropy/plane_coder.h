// One bit-plane of one block: which binary decisions are coded, and in which order. Encoder and decoder run this same
// code, one with the truth at hand, the other with the answers of the range decoder. Integers only.
//
// Coefficients come in the block's order. A quiet group, kGroup coefficients of which nothing nor anything around is
// significant yet, takes one decision while it stays so. A coefficient with no significant component takes one decision
// while it stays so; else each component takes one (the last none, where it must be the one), and a sign or a
// refinement bit as it needs.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "codec/entropy/block.h"
#include "codec/entropy/contexts.h"

namespace mvw {

inline constexpr unsigned kMaxComponents = 4;
inline constexpr unsigned kMaxPlanes = 28;  // magnitudes are below 2^28

/// The coefficients as known so far, coefficient-major (coefficient i, component c at i * components + c): magnitude
/// with the planes not yet coded zero, doubled, plus 1 where negative.
using Entries = std::vector<std::uint32_t>;
constexpr std::uint32_t magnitude_of(std::uint32_t entry) {
    return entry >> 1;
}

/// What a block's planes leave behind for the next one.
struct BlockProgress {
    BlockProgress(std::size_t size, unsigned component_count)
        : components(component_count), entries(size * component_count), awake(size) {}

    unsigned components;
    unsigned top = kMaxPlanes;  // the block's first plane
    BlockModel model;
    Entries entries;
    std::vector<std::uint8_t> awake;  // 1 where a coefficient or a neighbour of it has a significant component
};

/// Codes one plane after the other of one block.
///
/// Coder   bool code(std::uint32_t probability, bool truth): the bit, truth itself when encoding
///         bool any(first, last, plane): truth: has an entry of [first, last) a bit at `plane` or above
///         std::uint32_t truth(at): the entry in full when encoding, anything when decoding
///         bool stopped(): no more decisions can be had
template <typename Coder>
class PlaneCoder {
 public:
    /// parent: entries of the block one level below with at least the planes above `plane`, or empty (zeros).
    PlaneCoder(const BlockShape& shape, std::span<const std::uint32_t> parent, unsigned plane, BlockProgress& progress,
               Coder& coder)
        : shape_(shape),
          components_(progress.components),
          plane_(plane),
          model_(progress.model),
          entries_(progress.entries),
          awake_(progress.awake),
          depth_(progress.top - plane),
          coder_(coder) {
        summarize(parent);
    }

    /// Returns how many entries were completed: all, unless the coder stopped.
    std::size_t run() {
        const std::size_t size = shape_.size();
        for (std::size_t i = 0; i < size; ++i) {
            bool in_group = false;
            if (i % kGroup == 0 && i + kGroup <= size && quiet(i)) {
                in_group = group(i);
                if (coder_.stopped()) return i * components_;
                if (!in_group) {
                    i += kGroup - 1;
                    continue;
                }
            }
            if (!coefficient(i, in_group)) return stopped_at_;
        }
        return entries_.size();
    }

 private:
    static constexpr std::size_t kGroup = 8;
    static constexpr std::uint32_t kMaxAbove = 50;  // so that two parents' sum fits a byte

    /// Parents' magnitudes in units of the plane above, a byte for each component; sums of two never carry.
    void summarize(std::span<const std::uint32_t> parent) {
        if (parent.empty() || shape_.parents().empty()) return;
        parents_.resize(parent.size() / components_);
        std::uint32_t any = 0;
        for (std::size_t k = 0; k < parents_.size(); ++k) {
            std::uint32_t packed = 0;
            for (unsigned c = 0; c < components_; ++c) {
                const std::uint32_t above = magnitude_of(parent[k * components_ + c]) >> (plane_ + 1);
                packed |= (above < kMaxAbove ? above : kMaxAbove) << (8 * c);
            }
            parents_[k] = packed;
            any |= packed;
        }
        if (any == 0) parents_.clear();
        parent_entries_ = parent;
    }

    std::uint32_t above(std::size_t i) const {
        if (parents_.empty()) return 0;
        std::uint32_t sum = 0;
        for (const std::uint32_t k : shape_.parents()[i])
            if (k != kNone) sum += parents_[k];
        return sum;
    }

    bool quiet(std::size_t i) const {
        std::uint64_t any_awake = 0;
        static_assert(sizeof any_awake == kGroup);
        std::memcpy(&any_awake, &awake_[i], kGroup);
        if (any_awake != 0) return false;
        std::uint32_t any_above = 0;
        for (std::size_t k = i; k < i + kGroup; ++k) any_above |= above(k);
        return any_above == 0;
    }

    bool code(AdaptiveBit& bit, bool truth) {
        const bool answer = coder_.code(bit.probability(), truth);
        bit.learn(answer);
        return answer;
    }

    bool code(const BlockModel::Pair& pair, bool truth) {
        const int a = pair.flip_a ? -pair.a->logit() : pair.a->logit();
        const int b = pair.flip_b ? -pair.b->logit() : pair.b->logit();
        const std::uint32_t probability = logistic::probability(pair.weights->mix(a, b));
        const bool answer = coder_.code(probability, truth);
        pair.weights->learn(a, b, (answer ? 65536 : 0) - static_cast<std::int32_t>(probability));
        pair.a->learn(answer != pair.flip_a);
        pair.b->learn(answer != pair.flip_b);
        return answer;
    }

    bool group(std::size_t i) {
        const bool any =
            code(model_.group(depth_, history_), coder_.any(i * components_, (i + kGroup) * components_, plane_));
        history_ = (history_ * 2 + any) & 7u;
        return any;
    }

    /// Quarters of the plane's unit, up to where all context classes end.
    [[nodiscard]] std::uint32_t quarters(std::uint64_t magnitude) const {
        return static_cast<std::uint32_t>(std::min<std::uint64_t>((magnitude << 2) >> plane_, 1023));
    }

    /// Fills around_ for coefficient i, of which nothing but `entries_` and the parents is used.
    void look_around(std::size_t i) {
        std::array<std::uint64_t, kMaxComponents> near{}, far{};
        if (awake_[i] != 0) {
            const BlockShape::Neighbors& neighbors = shape_.neighbors()[i];
            for (std::size_t n = 0; n < neighbors.size(); ++n) {
                if (neighbors[n] == kNone) continue;
                const std::uint32_t* entry = &entries_[std::size_t{neighbors[n]} * components_];
                auto& sum = n < 4 ? near : far;
                for (unsigned c = 0; c < components_; ++c) sum[c] += magnitude_of(entry[c]);
            }
        }
        const std::uint32_t packed = above(i);
        std::uint32_t all_above = 0;
        for (unsigned c = 0; c < components_; ++c) all_above += (packed >> (8 * c)) & 255u;
        for (unsigned c = 0; c < components_; ++c) {
            Surroundings& s = around_[c];
            const std::uint32_t own_above = (packed >> (8 * c)) & 255u;
            s.near = quarters(near[c]);
            s.far = quarters(far[c]);
            s.above = 8 * own_above;
            s.above_others = 8 * (all_above - own_above);
            s.siblings = 0;
        }
    }

    /// Component 0 counts double for the others: it is coded first and tells most.
    [[nodiscard]] std::uint32_t siblings(std::size_t i, unsigned component) const {
        std::uint64_t sum = 0;
        for (unsigned c = 0; c < components_; ++c)
            if (c != component) sum += std::uint64_t{magnitude_of(entries_[i * components_ + c])} << (c == 0);
        return quarters(sum);
    }

    /// False where the coder stopped; stopped_at_ then says where.
    bool coefficient(std::size_t i, bool in_group) {
        const std::size_t first = i * components_;
        stopped_at_ = first;
        look_around(i);
        bool was_zero = true, found = false;
        for (unsigned c = 0; c < components_; ++c) was_zero &= entries_[first + c] == 0;
        if (was_zero) {
            if (!becomes_significant(i, in_group) || coder_.stopped()) return !coder_.stopped();
        }
        for (unsigned c = 0; c < components_; ++c, ++stopped_at_) {
            if (entries_[stopped_at_] != 0) {
                refine(c);
            } else {
                const bool last_chance = was_zero && !found && c + 1 == components_;
                if (last_chance || component_becomes_significant(i, c, was_zero ? (found ? 1 : 2) : 0)) {
                    found = true;
                    if (!coder_.stopped()) add_significant(i, c);
                }
            }
            if (coder_.stopped()) return false;
        }
        return true;
    }

    bool becomes_significant(std::size_t i, bool in_group) {
        std::uint32_t others = 0;
        for (unsigned c = 1; c < components_; ++c) others += around_[c].activity();
        const std::size_t first = i * components_;
        return code(model_.coefficient(around_[0], others / 2, in_group),
                    coder_.any(first, first + components_, plane_));
    }

    bool component_becomes_significant(std::size_t i, unsigned c, unsigned state) {
        around_[c].siblings = siblings(i, c);
        return code(model_.significance(c, around_[c], state), truth_bit());
    }

    [[nodiscard]] bool truth_bit() const { return (magnitude_of(coder_.truth(stopped_at_)) >> plane_ & 1u) != 0; }

    void refine(unsigned c) {
        std::uint32_t& entry = entries_[stopped_at_];
        AdaptiveBit& model = model_.refinement(c, magnitude_of(entry) >> (plane_ + 1), around_[c].near, around_[c].far);
        const bool bit = code(model, truth_bit());
        if (!coder_.stopped()) entry |= std::uint32_t{bit} << (plane_ + 1);
    }

    void add_significant(std::size_t i, unsigned c) {
        const bool negative = code(model_.sign(c, signs_around(i, c)), (coder_.truth(stopped_at_) & 1u) != 0);
        if (coder_.stopped()) return;
        entries_[stopped_at_] = (2u << plane_) | std::uint32_t{negative};
        awake_[i] = 1;
        for (const std::uint32_t n : shape_.neighbors()[i])
            if (n != kNone) awake_[n] = 1;
    }

    static int sign_of(std::uint32_t entry) { return entry == 0 ? 0 : (entry & 1u) != 0 ? -1 : 1; }

    [[nodiscard]] SignsAround signs_around(std::size_t i, unsigned c) const {
        SignsAround signs;
        const BlockShape::Neighbors& neighbors = shape_.neighbors()[i];
        for (std::size_t n = 0; n < neighbors.size(); ++n)
            if (neighbors[n] != kNone)
                (n < 4   ? signs.near
                 : n < 6 ? signs.line
                         : signs.far) += sign_of(entries_[std::size_t{neighbors[n]} * components_ + c]);
        if (parents_.empty()) return signs;
        for (const std::uint32_t k : shape_.parents()[i]) {
            if (k == kNone) continue;
            const std::uint32_t entry = parent_entries_[std::size_t{k} * components_ + c];
            if (magnitude_of(entry) >> (plane_ + 1) != 0) signs.above += sign_of(entry);
        }
        return signs;
    }

    const BlockShape& shape_;
    const unsigned components_, plane_;
    BlockModel& model_;
    Entries& entries_;
    std::vector<std::uint8_t>& awake_;
    const unsigned depth_;
    Coder& coder_;
    std::span<const std::uint32_t> parent_entries_;
    std::vector<std::uint32_t> parents_;  // packed; empty where all are zero
    unsigned history_ = 0;
    std::array<Surroundings, kMaxComponents> around_{};
    std::size_t stopped_at_ = 0;  // the entry that is being coded
};

}  // namespace mvw
