// The order in which a worker takes groups through the stages of a step, so that a group is still in the cache when its
// next stage comes.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

namespace mvw {

/// Groups around each group, itself included: those of group g are next[first[g]] ... next[first[g + 1] - 1].
struct GroupGraph {
    std::vector<std::uint32_t> first, next;
    [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(first.size() - 1); }
};

/// Each group has a slot of a worker's scratch from its first stage to its last; a slot then serves another group, so
/// that little scratch is in use and stays in the cache.
///
/// Stage s > 0 of a group may run when stage s - 1 of all groups around it has. What a worker can do on its own runs in
/// one sweep over its range; what waits for another worker's groups comes stage by stage afterwards.
class Pipeline {
 public:
    Pipeline() = default;
    /// For the groups [begin, end) of one worker.
    Pipeline(const GroupGraph& graph, std::uint32_t begin, std::uint32_t end, unsigned stages);

    /// Slot of each group of the range, below slot_count(). Holds for run() alone.
    [[nodiscard]] const std::vector<std::uint32_t>& slots() const { return slots_; }
    [[nodiscard]] std::uint32_t slot_count() const { return slot_count_; }

    /// work(stage, group) for each of both; sync() lets all workers meet, stages - 1 times.
    template <typename Work, typename Sync>
    void run(Work work, Sync sync) const {
        for (const auto& [stage, group] : sweep_) work(stage, group);
        for (unsigned stage = 1; stage < late_.size(); ++stage) {
            sync();
            for (const std::uint32_t group : late_[stage]) work(stage, group);
        }
    }

    /// The same with all groups through one stage before any enters the next.
    template <typename Work, typename Sync>
    void run_in_phases(Work work, Sync sync) const {
        for (unsigned stage = 0; stage < late_.size(); ++stage) {
            if (stage > 0) sync();
            for (std::uint32_t group = begin_; group < end_; ++group) work(stage, group);
        }
    }

 private:
    void choose_slots();

    std::uint32_t begin_ = 0, end_ = 0, slot_count_ = 0;
    std::vector<std::uint32_t> slots_;
    std::vector<std::pair<unsigned, std::uint32_t>> sweep_;
    std::vector<std::vector<std::uint32_t>> late_;  // by stage
};

}  // namespace mvw
