#include "codec/remesh/rings.h"

#include <numeric>

namespace mvw {

Rings::Rings(const std::vector<Face>& triangles, std::size_t vertices)
    : begin_(vertices + 1, 0), triangles_(triangles.size() * 3) {
    for (const Face& f : triangles)
        for (const std::uint32_t v : f) ++begin_[v + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    std::vector<std::uint32_t> at(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const Face& f = triangles[t];
        for (std::size_t k = 0; k < 3; ++k) triangles_[at[f[k]]++] = {f[(k + 1) % 3], f[(k + 2) % 3], t};
    }
}

std::vector<std::vector<std::uint32_t>> Rings::independent_groups(const std::vector<std::uint8_t>& fixed) const {
    constexpr std::uint8_t kNoColor = 64;
    std::vector<std::vector<std::uint32_t>> groups;
    std::vector<std::uint8_t> color(fixed.size(), kNoColor);
    for (std::uint32_t v = 0; v < fixed.size(); ++v) {
        if (fixed[v] != 0) continue;
        std::uint64_t used = 0;
        for (const RingTriangle& t : at(v))
            for (const std::uint32_t u : {t.first, t.second})
                if (color[u] != kNoColor) used |= std::uint64_t{1} << color[u];
        std::uint8_t c = 0;
        while (c + 1 < kNoColor && (used >> c & 1) != 0) ++c;
        color[v] = c;
        if (c >= groups.size()) groups.resize(c + 1u);
        groups[c].push_back(v);
    }
    return groups;
}

}  // namespace mvw
