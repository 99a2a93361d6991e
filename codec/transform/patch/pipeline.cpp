#include "codec/transform/patch/pipeline.h"

#include <algorithm>

namespace mvw {

Pipeline::Pipeline(const GroupGraph& graph, std::uint32_t begin, std::uint32_t end, unsigned stages)
    : begin_(begin), end_(end), late_(stages) {
    constexpr std::uint32_t kLate = 0xFFFFFFFFu;
    // After which group's first stage the current stage of each can run.
    std::vector<std::uint32_t> ready(end - begin);
    for (std::uint32_t g = begin; g < end; ++g) ready[g - begin] = g;
    std::vector<std::vector<std::pair<unsigned, std::uint32_t>>> after(end - begin);
    for (std::uint32_t g = begin; g < end; ++g) after[g - begin].emplace_back(0, g);
    for (unsigned stage = 1; stage < stages; ++stage) {
        std::vector<std::uint32_t> next(ready.size());
        for (std::uint32_t g = begin; g < end; ++g) {
            std::uint32_t last = g;
            for (std::uint32_t i = graph.first[g]; i < graph.first[g + 1]; ++i) {
                const std::uint32_t other = graph.next[i];
                last = std::max(last, other < begin || other >= end ? kLate : ready[other - begin]);
            }
            next[g - begin] = last;
            if (last == kLate)
                late_[stage].push_back(g);
            else
                after[last - begin].emplace_back(stage, g);
        }
        ready = std::move(next);
    }
    for (const auto& step : after) sweep_.insert(sweep_.end(), step.begin(), step.end());
    choose_slots();
}

void Pipeline::choose_slots() {
    slots_.resize(end_ - begin_);
    std::vector<std::uint32_t> idle;
    for (const auto& [stage, group] : sweep_) {
        std::uint32_t& slot = slots_[group - begin_];
        if (stage == 0) {
            slot = idle.empty() ? slot_count_++ : idle.back();
            if (!idle.empty()) idle.pop_back();
        }
        if (stage + 1 == late_.size()) idle.push_back(slot);
    }
}

}  // namespace mvw
