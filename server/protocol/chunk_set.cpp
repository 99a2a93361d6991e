#include "server/protocol/chunk_set.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace mvw::protocol {
namespace {

// The first range that ends at or after `index`.
template <typename Ranges>
auto find_range(Ranges& ranges, std::uint32_t index) {
    return std::lower_bound(ranges.begin(), ranges.end(), index,
                            [](const ChunkSet::Range& r, std::uint32_t i) { return r.last < i; });
}

}  // namespace

void ChunkSet::insert(std::uint32_t index) {
    const auto next = find_range(ranges_, index);
    if (next != ranges_.end() && next->first <= index) return;
    const bool joins_next = next != ranges_.end() && next->first - 1 == index;
    const bool joins_previous = next != ranges_.begin() && std::prev(next)->last + 1 == index;
    if (joins_previous && joins_next) {
        std::prev(next)->last = next->last;
        ranges_.erase(next);
    } else if (joins_previous) {
        std::prev(next)->last = index;
    } else if (joins_next) {
        next->first = index;
    } else {
        ranges_.insert(next, {index, index});
    }
}

void ChunkSet::merge(const ChunkSet& other) {
    std::vector<Range> all;
    all.reserve(ranges_.size() + other.ranges_.size());
    std::merge(ranges_.begin(), ranges_.end(), other.ranges_.begin(), other.ranges_.end(), std::back_inserter(all),
               [](const Range& a, const Range& b) { return a.first < b.first; });
    ranges_.clear();
    for (const Range& r : all) {
        if (!ranges_.empty() && r.first <= std::uint64_t{ranges_.back().last} + 1)
            ranges_.back().last = std::max(ranges_.back().last, r.last);
        else
            ranges_.push_back(r);
    }
}

bool ChunkSet::contains(std::uint32_t index) const {
    const auto range = find_range(ranges_, index);
    return range != ranges_.end() && range->first <= index;
}

std::uint64_t ChunkSet::count() const {
    std::uint64_t n = 0;
    for (const Range& r : ranges_) n += std::uint64_t{r.last} - r.first + 1;
    return n;
}

void ChunkSet::write(ByteWriter& out) const {
    out.varint(ranges_.size());
    std::uint64_t free = 0;  // the least index that the next range may start with
    for (const Range& r : ranges_) {
        out.varint(r.first - free);
        out.varint(r.last - r.first);
        free = std::uint64_t{r.last} + 2;
    }
}

Result<ChunkSet> ChunkSet::read(ByteReader& in) {
    constexpr std::uint64_t kMaxIndex = std::numeric_limits<std::uint32_t>::max();
    const std::uint64_t count = in.varint();
    if (!in.ok()) return in.error();
    if (count > in.remaining() / 2)  // two bytes a range at least
        return Error{Errc::Malformed, in.offset(), "chunk set: more ranges than bytes"};
    ChunkSet set;
    set.ranges_.reserve(count);
    std::uint64_t free = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t gap = in.varint();
        const std::uint64_t more = in.varint();
        if (!in.ok()) return in.error();
        if (gap > kMaxIndex || more > kMaxIndex || free + gap + more > kMaxIndex)
            return Error{Errc::Malformed, in.offset(), "chunk set: a range beyond 32 bits"};
        const std::uint64_t first = free + gap;
        set.ranges_.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(first + more)});
        free = first + more + 2;
    }
    return set;
}

}  // namespace mvw::protocol
