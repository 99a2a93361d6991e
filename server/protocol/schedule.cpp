#include "server/protocol/schedule.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace mvw::protocol {
namespace {

constexpr unsigned kBasePass = 256;  // above every u8 priority

bool tile_less(const TilePriority& a, const TilePriority& b) {
    return std::pair(a.part, a.tile) < std::pair(b.part, b.tile);
}

// One past the first chunk that leaves at most the target error; all where none does.
std::uint32_t target_end(const Toc& toc, float target_error) {
    const auto count = static_cast<std::uint32_t>(toc.chunks.size());
    if (target_error <= 0) return count;
    for (std::uint32_t i = 0; i < count; ++i)
        if (toc.chunks[i].error <= target_error) return i + 1;
    return count;
}

// Base first, then each priority that occurs, highest first; 0 means not at all.
std::vector<unsigned> priorities(const Request& request) {
    std::vector<unsigned> passes{kBasePass};
    if (request.other_priority != 0) passes.push_back(request.other_priority);
    for (const TilePriority& t : request.tiles)
        if (t.priority != 0) passes.push_back(t.priority);
    std::sort(passes.begin(), passes.end(), std::greater<>());
    passes.erase(std::unique(passes.begin(), passes.end()), passes.end());
    return passes;
}

}  // namespace

bool wants_everything(const FileHeader& header, const Request& request) {
    const auto is_capped = [&](const TilePriority& t) {
        return t.priority == 0 || (t.part < header.parts.size() && t.max_level < header.parts[t.part].levels);
    };
    return request.other_priority != 0 && request.max_level > finest_level(header) &&
           request.max_layer + 1 >= header.layers &&
           std::none_of(request.tiles.begin(), request.tiles.end(), is_capped);
}

Schedule::Schedule(const Toc& toc, Request request)
    : toc_(&toc),
      request_(std::move(request)),
      passes_(priorities(request_)),
      end_(target_end(toc, request_.target_error)),
      held_bytes_(toc.header.header_bytes) {
    std::stable_sort(request_.tiles.begin(), request_.tiles.end(), tile_less);
    for (const ChunkSet::Range& r : request_.held.ranges())
        for (std::uint64_t i = r.first; i <= r.last && i < toc.chunks.size(); ++i) held_bytes_ += toc.chunks[i].length;
}

bool Schedule::in_pass(const ChunkId& id) const {
    const unsigned pass = passes_[pass_];
    if (id.channel == Channel::Original || toc_->header.parts[id.part].supersedes)
        return pass_ + 1 == passes_.size() && wants_everything(toc_->header, request_);
    if (leads_to_base(id.channel)) return pass == kBasePass;
    if (pass == kBasePass || id.level > request_.max_level || id.layer > request_.max_layer) return false;
    // Coarse levels have one tile for all: whatever is seen of the part needs it, before anything finer.
    if (id.channel == Channel::Attributes || id.level < toc_->header.parts[id.part].first_tiled_level)
        return pass_ == 1;
    const TilePriority key{id.part, id.tile};
    const auto tile = std::lower_bound(request_.tiles.begin(), request_.tiles.end(), key, tile_less);
    if (tile == request_.tiles.end() || tile_less(key, *tile)) return request_.other_priority == pass;
    return tile->priority == pass && id.level <= tile->max_level;
}

std::optional<std::uint32_t> Schedule::next(const ChunkSet& sent) {
    for (; pass_ < passes_.size(); ++pass_, at_ = 0) {
        for (; at_ < end_; ++at_) {
            const ChunkEntry& chunk = toc_->chunks[at_];
            if (!in_pass(chunk.id) || sent.contains(at_)) continue;
            if (request_.byte_budget != 0 && held_bytes_ + chunk.length > request_.byte_budget) {
                reason_ = EndReason::Budget;
                pass_ = passes_.size();
                return std::nullopt;
            }
            held_bytes_ += chunk.length;
            return at_++;
        }
    }
    return std::nullopt;
}

}  // namespace mvw::protocol
