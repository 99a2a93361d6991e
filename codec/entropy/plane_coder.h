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

#if defined(__EMSCRIPTEN__)
inline constexpr bool kSmall = true;  // in a browser's module its size counts
#else
inline constexpr bool kSmall = false;
#endif
inline constexpr unsigned kMaxComponents = 4;
inline constexpr unsigned kMaxPlanes = 28;  // magnitudes are below 2^28

/// A component as known so far: its magnitude with the planes not yet coded zero, doubled, plus 1 where negative.
constexpr std::uint32_t magnitude_of(std::uint32_t entry) {
    return entry >> 1;
}
/// Coefficient-major: coefficient i, component c at i * components + c.
using Entries = std::vector<std::uint32_t>;
/// The components of one coefficient, as wide as a vector; those that a block has not are zero.
struct alignas(16) EntryRow {
    std::array<std::uint32_t, kMaxComponents> of{};
};
/// One for each coefficient, and one of zeros behind them for neighbours and parents that there are not.
using EntryRows = std::vector<EntryRow>;

inline EntryRows rows_of(std::span<const std::uint32_t> entries, unsigned components) {
    EntryRows rows(entries.empty() ? 0 : entries.size() / components + 1);
    for (std::size_t at = 0; at < entries.size(); ++at) rows[at / components].of[at % components] = entries[at];
    return rows;
}

/// What a block's planes leave behind for the next one.
struct BlockProgress {
    BlockProgress(std::size_t size, unsigned component_count)
        : components(component_count), rows(size + 1), awake(size + 1) {}

    unsigned components;
    unsigned top = kMaxPlanes;  // the block's first plane
    BlockModel model;
    EntryRows rows;
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
    /// parent: rows of the block one level below with at least the planes above `plane`, or empty (zeros).
    PlaneCoder(const BlockShape& shape, std::span<const EntryRow> parent, unsigned plane, BlockProgress& progress,
               Coder& coder)
        : shape_(shape),
          components_(progress.components),
          plane_(plane),
          model_(progress.model),
          rows_(progress.rows.data()),
          awake_(progress.awake.data()),
          size_(shape.size()),
          depth_(progress.top - plane),
          coder_(coder) {
        summarize(parent);
    }

    /// Returns how many entries were completed: all, unless the coder stopped.
    std::size_t run() { return kSmall || components_ != 3 ? run<0>() : run<3>(); }

 private:
    /// kCount: the components where that is known beforehand, else 0.
    template <unsigned kCount>
    std::size_t run() {
        for (std::size_t i = 0; i < size_; ++i) {
            bool in_group = false;
            if (i % kGroup == 0 && i + kGroup <= size_ && quiet(i)) {
                in_group = group(i);
                if (coder_.stopped()) return i * components_;
                if (!in_group) {
                    i += kGroup - 1;
                    continue;
                }
            }
            if (!coefficient<kCount>(i, in_group)) return stopped_at_;
        }
        return size_ * components_;
    }

    static constexpr std::size_t kGroup = 8;
    static constexpr std::uint32_t kMaxAbove = 50;  // so that two parents' sum fits a byte

    /// Parents' magnitudes in units of the plane above, a byte for each component; sums of two never carry.
    void summarize(std::span<const EntryRow> parent) {
        if (parent.empty() || shape_.parents().empty()) return;
        parents_.resize(parent.size());
        std::uint32_t any = 0;
        for (std::size_t k = 0; k < parents_.size(); ++k) {
            std::uint32_t packed = 0;
            for (unsigned c = 0; c < kMaxComponents; ++c) {
                const std::uint32_t above = magnitude_of(parent[k].of[c]) >> (plane_ + 1);
                packed |= (above < kMaxAbove ? above : kMaxAbove) << (8 * c);
            }
            parents_[k] = packed;
            any |= packed;
        }
        if (any == 0) parents_.clear();
        parent_rows_ = parent;
    }

    std::uint32_t above(std::size_t i) const {
        if (parents_.empty()) return 0;
        const BlockShape::Parents& parents = shape_.parents()[i];
        return parents_[parents[0]] + parents_[parents[1]];
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
        pair.weights->learn(a, b, (static_cast<std::int32_t>(answer) << 16) - static_cast<std::int32_t>(probability));
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

    static constexpr std::uint32_t kMostQuarters = 1023;  // all context classes end before

    // Four components at once, in the vectors that gcc and clang have for every machine.
    using Four = std::uint32_t __attribute__((vector_size(16)));
    static Four load(const EntryRow& row) {
        Four v;
        std::memcpy(&v, &row, sizeof v);
        return v;
    }
    static Four at_most(Four v, std::uint32_t most) {
        const Four cap = Four{} + most, mask = reinterpret_cast<Four>(v < cap);
        return (v & mask) | (cap & ~mask);
    }
    /// Quarters of the plane's unit, up to where all context classes end.
    [[nodiscard]] Four quarters(Four magnitudes) const {
        return at_most(plane_ >= 2 ? magnitudes >> (plane_ - 2) : at_most(magnitudes, kMostQuarters) << (2 - plane_),
                       kMostQuarters);
    }
    static constexpr std::array<EntryRow, kMaxComponents> kComponentMasks{
        {{{~0u, 0, 0, 0}}, {{0, ~0u, 0, 0}}, {{0, 0, ~0u, 0}}, {{0, 0, 0, ~0u}}}};
    static void store(Four v, std::array<std::uint32_t, kMaxComponents>& to) { std::memcpy(&to, &v, sizeof v); }

    /// Fills near_, far_ and above_ for coefficient i, of which nothing but its rows and the parents is used.
    void look_around(std::size_t i) {
        Four near{}, far{};
        if (awake_[i] != 0) {
            const BlockShape::Neighbors& neighbors = shape_.neighbors()[i];
            for (std::size_t n = 0; n < 4; ++n) near += load(rows_[neighbors[n]]) >> 1;
            for (std::size_t n = 4; n < BlockShape::kNeighbors; ++n) far += load(rows_[neighbors[n]]) >> 1;
            near = quarters(near);
            far = quarters(far);
        }
        store(near, near_);
        store(far, far_);
        const std::uint32_t packed = above(i);
        for (unsigned c = 0; c < kMaxComponents; ++c) above_[c] = (packed >> (8 * c)) & 255u;
        all_above_ = above_[0] + above_[1] + above_[2] + above_[3];
    }
    [[nodiscard]] Surroundings around(unsigned c, std::uint32_t siblings) const {
        return {near_[c], far_[c], 8 * above_[c], 8 * (all_above_ - above_[c]), siblings};
    }

    /// False where the coder stopped; stopped_at_ then says where.
    template <unsigned kCount>
    bool coefficient(std::size_t i, bool in_group) {
        const unsigned count = kCount == 0 ? components_ : kCount;
        stopped_at_ = i * count;
        look_around(i);
        const std::array<std::uint32_t, kMaxComponents> before = rows_[i].of;
        const bool was_zero = (before[0] | before[1] | before[2] | before[3]) == 0;
        if (was_zero) {
            if (!becomes_significant(i, count, in_group) || coder_.stopped()) return !coder_.stopped();
        }
        // Component 0 counts double for the others: it is coded first and tells most.
        std::uint32_t siblings =
            2 * magnitude_of(before[0]) + magnitude_of(before[1]) + magnitude_of(before[2]) + magnitude_of(before[3]);
        Four row = load(rows_[i]);
        bool found = false;
        signs_known_ = false;
        for (unsigned c = 0; c < count && !coder_.stopped(); ++c) {
            std::uint32_t more = 0;  // to the entry
            if (before[c] != 0) {
                more = refine(before[c], c);
            } else {
                const bool last_chance = was_zero && !found && c + 1 == count;
                if (last_chance || component_becomes_significant(c, siblings, was_zero ? (found ? 1 : 2) : 0)) {
                    more = newly_significant(i, c);
                    found = true;
                }
            }
            if (coder_.stopped()) break;
            siblings += magnitude_of(more) << (c == 0);
            row |= (Four{} + more) & load(kComponentMasks[c]);
            ++stopped_at_;
        }
        // In one piece: neighbours will read it so, and a store in parts would have to reach the cache first.
        store(row, rows_[i].of);
        if (was_zero && stopped_at_ > i * count) wake_up(i);
        return !coder_.stopped();
    }

    bool becomes_significant(std::size_t i, unsigned count, bool in_group) {
        const Surroundings first = around(0, 0);
        std::uint32_t others = 0;
        for (unsigned c = 1; c < count; ++c) others += around(c, 0).activity();
        const std::size_t at = i * count;
        return code(model_.coefficient(first, others / 2, in_group), coder_.any(at, at + count, plane_));
    }

    bool component_becomes_significant(unsigned c, std::uint32_t siblings, unsigned state) {
        const auto in_quarters = static_cast<std::uint32_t>(
            std::min<std::uint64_t>((std::uint64_t{siblings} << 2) >> plane_, kMostQuarters));
        return code(model_.significance(c, around(c, in_quarters), state), truth_bit());
    }

    [[nodiscard]] bool truth_bit() const { return (magnitude_of(coder_.truth(stopped_at_)) >> plane_ & 1u) != 0; }

    /// What the plane adds to the entry.
    std::uint32_t refine(std::uint32_t entry, unsigned c) {
        AdaptiveBit& model = model_.refinement(c, magnitude_of(entry) >> (plane_ + 1), near_[c], far_[c]);
        return std::uint32_t{code(model, truth_bit())} << (plane_ + 1);
    }
    std::uint32_t newly_significant(std::size_t i, unsigned c) {
        if (coder_.stopped()) return 0;
        return (2u << plane_) |
               std::uint32_t{code(model_.sign(c, signs_around(i, c)), (coder_.truth(stopped_at_) & 1u) != 0)};
    }
    void wake_up(std::size_t i) {
        const EntryRow& row = rows_[i];
        if ((row.of[0] | row.of[1] | row.of[2] | row.of[3]) == 0) return;  // the coder stopped before
        awake_[i] = 1;
        for (const std::uint32_t n : shape_.neighbors()[i]) awake_[n] = 1;
    }

    /// 1, -1 or, where the entry is zero, 0.
    static Four signs_of(Four entries) { return -reinterpret_cast<Four>(entries != Four{}) - ((entries & 1u) << 1); }
    static int sign_of(std::uint32_t entry) { return int{entry != 0} - 2 * static_cast<int>(entry & 1u); }

    [[nodiscard]] SignsAround signs_around(std::size_t i, unsigned c) {
        if (!signs_known_) sum_signs(i);
        SignsAround signs{static_cast<int>(near_signs_[c]), static_cast<int>(line_signs_[c]),
                          static_cast<int>(far_signs_[c]), 0};
        if (parents_.empty()) return signs;
        for (const std::uint32_t k : shape_.parents()[i]) {
            const std::uint32_t entry = parent_rows_[k].of[c];
            if (magnitude_of(entry) >> (plane_ + 1) != 0) signs.above += sign_of(entry);
        }
        return signs;
    }
    /// Of all components at once: none changes while coefficient i is coded.
    void sum_signs(std::size_t i) {
        const BlockShape::Neighbors& neighbors = shape_.neighbors()[i];
        Four near{}, line{}, far{};
        for (std::size_t n = 0; n < 4; ++n) near += signs_of(load(rows_[neighbors[n]]));
        for (std::size_t n = 4; n < 6; ++n) line += signs_of(load(rows_[neighbors[n]]));
        for (std::size_t n = 6; n < BlockShape::kNeighbors; ++n) far += signs_of(load(rows_[neighbors[n]]));
        store(near, near_signs_);
        store(line, line_signs_);
        store(far, far_signs_);
        signs_known_ = true;
    }

    const BlockShape& shape_;
    const unsigned components_, plane_;
    BlockModel& model_;
    EntryRow* const rows_;
    std::uint8_t* const awake_;
    const std::size_t size_;
    const unsigned depth_;
    Coder& coder_;
    std::span<const EntryRow> parent_rows_;
    std::vector<std::uint32_t> parents_;  // packed, and a zero behind; empty where all are zero
    unsigned history_ = 0;
    // Around the coefficient that is being coded, by component: magnitudes in quarters of the plane's unit, parents' in
    // twice it, signs.
    std::array<std::uint32_t, kMaxComponents> near_{}, far_{}, above_{}, near_signs_{}, line_signs_{}, far_signs_{};
    std::uint32_t all_above_ = 0;
    bool signs_known_ = false;
    std::size_t stopped_at_ = 0;  // the entry that is being coded
};

}  // namespace mvw
