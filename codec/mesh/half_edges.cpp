#include "codec/mesh/half_edges.h"

#include <algorithm>
#include <utility>

#include "codec/mesh/semi_regular.h"

namespace mvw {

EdgeGroups group_edges(std::span<const Face> faces, std::uint32_t vertex_count, std::span<const std::uint8_t> use) {
    const auto count = static_cast<std::uint32_t>(3 * faces.size());
    const auto ends = [&](std::uint32_t h) { return std::minmax(faces[h / 3][h % 3], faces[h / 3][(h % 3 + 1) % 3]); };
    const auto used = [&](std::uint32_t h) { return use.empty() || use[h] != 0; };

    // Counting sort by the lower vertex, then a sort of the few entries at each.
    std::vector<std::uint32_t> bucket(std::size_t{vertex_count} + 1, 0);
    for (std::uint32_t h = 0; h < count; ++h)
        if (used(h)) ++bucket[ends(h).first + 1];
    for (std::uint32_t v = 0; v < vertex_count; ++v) bucket[v + 1] += bucket[v];
    std::vector<std::pair<std::uint32_t, std::uint32_t>> entries(bucket.back());  // higher vertex, half-edge
    std::vector<std::uint32_t> fill(bucket.begin(), bucket.end() - 1);
    for (std::uint32_t h = 0; h < count; ++h)
        if (used(h)) entries[fill[ends(h).first]++] = {ends(h).second, h};

    EdgeGroups groups;
    groups.half_edges.reserve(entries.size());
    groups.starts.reserve(entries.size() / 2 + 1);
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
        std::sort(entries.begin() + bucket[v], entries.begin() + bucket[v + 1]);
        for (std::uint32_t i = bucket[v]; i < bucket[v + 1]; ++i) {
            if (i == bucket[v] || entries[i].first != entries[i - 1].first) groups.starts.push_back(i);
            groups.half_edges.push_back(entries[i].second);
        }
    }
    groups.starts.push_back(static_cast<std::uint32_t>(entries.size()));
    return groups;
}

Fans find_fans(std::span<const std::uint32_t> mates) {
    Fans fans;
    fans.of_corner.assign(mates.size(), kNone);
    for (std::uint32_t corner = 0; corner < mates.size(); ++corner) {
        if (fans.of_corner[corner] != kNone) continue;
        const std::uint32_t fan = fans.count++;
        fans.of_corner[corner] = fan;
        // Clockwise across the side that leaves the corner, then counter-clockwise across the one that enters it.
        for (std::uint32_t at = corner; mates[at] != kNone;) {
            at = next_half_edge(mates[at]);
            if (fans.of_corner[at] != kNone) break;
            fans.of_corner[at] = fan;
        }
        for (std::uint32_t at = corner; mates[previous_half_edge(at)] != kNone;) {
            at = mates[previous_half_edge(at)];
            if (fans.of_corner[at] != kNone) break;
            fans.of_corner[at] = fan;
        }
    }
    return fans;
}

}  // namespace mvw
