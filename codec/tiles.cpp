#include "codec/tiles.h"

#include <algorithm>
#include <array>

namespace mvw {

namespace {

constexpr unsigned kRounds = 4;

/// Neighbours of face f across its sides 0, 1, 2; kNone on a boundary.
std::array<std::uint32_t, 3> neighbours(const BaseMesh& base, std::uint32_t f) {
    std::array<std::uint32_t, 3> out{};
    for (unsigned s = 0; s < 3; ++s) out[s] = base.beyond(f, s).face;
    return out;
}

/// All faces breadth first, component after component, each from its lowest face.
std::vector<std::uint32_t> breadth_first(const BaseMesh& base) {
    std::vector<std::uint32_t> order;
    order.reserve(base.face_count());
    std::vector<std::uint8_t> seen(base.face_count(), 0);
    for (std::uint32_t start = 0; start < base.face_count(); ++start) {
        if (seen[start]) continue;
        seen[start] = 1;
        order.push_back(start);
        for (std::size_t i = order.size() - 1; i < order.size(); ++i)
            for (const std::uint32_t g : neighbours(base, order[i]))
                if (g != kNone && !seen[g]) seen[g] = 1, order.push_back(g);
    }
    return order;
}

/// Tiles take one free face each in turn, nearest to their seed first; what no tile reaches goes to the lastest one.
std::vector<std::uint32_t> grow(const BaseMesh& base, const std::vector<std::uint32_t>& seeds,
                                const std::vector<std::uint32_t>& order) {
    std::vector<std::uint32_t> tile(base.face_count(), kNone);
    std::vector<std::vector<std::uint32_t>> queue(seeds.size());
    std::vector<std::size_t> next(seeds.size(), 0);
    std::vector<std::uint32_t> active;
    const auto take = [&](std::uint32_t t, std::uint32_t f) {
        tile[f] = t;
        for (const std::uint32_t g : neighbours(base, f))
            if (g != kNone && tile[g] == kNone) queue[t].push_back(g);
    };
    for (std::uint32_t t = 0; t < seeds.size(); ++t) tile[seeds[t]] = t, active.push_back(t);
    for (std::uint32_t t = 0; t < seeds.size(); ++t) take(t, seeds[t]);
    while (!active.empty()) {
        std::size_t kept = 0;
        for (const std::uint32_t t : active) {
            while (next[t] < queue[t].size() && tile[queue[t][next[t]]] != kNone) ++next[t];
            if (next[t] == queue[t].size()) continue;
            take(t, queue[t][next[t]]);
            active[kept++] = t;
        }
        active.resize(kept);
    }
    for (std::uint32_t last = 0; const std::uint32_t f : order) {
        if (tile[f] == kNone) tile[f] = last;
        last = tile[f];
    }
    return tile;
}

/// The face of each tile that is farthest from the tile's border (the last one that waves from all borders reach).
std::vector<std::uint32_t> centers(const BaseMesh& base, const std::vector<std::uint32_t>& tile,
                                   std::vector<std::uint32_t> seeds) {
    std::vector<std::uint8_t> seen(base.face_count(), 0);
    std::vector<std::uint32_t> wave;
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        for (const std::uint32_t g : neighbours(base, f))
            if (!seen[f] && (g == kNone || tile[g] != tile[f])) seen[f] = 1, wave.push_back(f);
    for (std::size_t i = 0; i < wave.size(); ++i) {
        seeds[tile[wave[i]]] = wave[i];
        for (const std::uint32_t g : neighbours(base, wave[i]))
            if (g != kNone && !seen[g]) seen[g] = 1, wave.push_back(g);
    }
    return seeds;
}

}  // namespace

std::vector<std::uint16_t> tile_of_faces(const BaseMesh& base, unsigned tiles) {
    if (tiles <= 1) return std::vector<std::uint16_t>(base.face_count(), 0);
    const std::vector<std::uint32_t> order = breadth_first(base);
    std::vector<std::uint32_t> seeds(tiles);
    for (std::uint64_t t = 0; t < tiles; ++t) seeds[t] = order[t * order.size() / tiles];
    std::vector<std::uint32_t> tile = grow(base, seeds, order);
    for (unsigned round = 1; round < kRounds; ++round) {
        seeds = centers(base, tile, std::move(seeds));
        tile = grow(base, seeds, order);
    }
    return {tile.begin(), tile.end()};
}

}  // namespace mvw
