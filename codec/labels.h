// Crease bits of base edges and material labels of base faces: contexts that both directions share (FORMAT.md 4.2).
// Coder is the range encoder or decoder behind `bool code(AdaptiveBit&, bool truth)`; a decoder ignores the truth.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "codec/entropy/plane_coder.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// One bit for each edge in order; context: how many edges before it that touch its ends are creases (0, 1, 2, more).
template <typename Coder>
void code_creases(const BaseMesh& base, std::vector<std::uint8_t>& creases, Coder& coder) {
    std::vector<std::uint8_t> touched(base.vertex_count(), 0);
    std::array<AdaptiveBit, 4> bits;
    for (std::size_t e = 0; e < creases.size(); ++e) {
        const auto [a, b] = base.edges()[e].v;
        const unsigned around = touched[a] + touched[b];
        creases[e] = coder.code(bits[around < 3 ? around : 3], creases[e] != 0);
        for (const std::uint32_t v : {a, b}) touched[v] = static_cast<std::uint8_t>((touched[v] + creases[e]) & 127);
    }
}

inline constexpr std::size_t kLatestLabels = 8;

/// One label for each face in order: as predicted, that of its neighbour of lowest side among faces before it (else of
/// the face before); or one of the latest that were not, the latest first; or 32 bits from the top. O(F).
template <typename Coder>
void code_materials(const BaseMesh& base, std::vector<std::uint32_t>& labels, Coder& coder) {
    std::array<AdaptiveBit, 2> same;               // context: whether neighbours before it differ
    std::array<AdaptiveBit, kLatestLabels> is_it;  // context: how many it was not
    std::vector<std::uint32_t> latest;
    for (std::uint32_t f = 0; f < labels.size(); ++f) {
        std::uint32_t predicted = f > 0 ? labels[f - 1] : 0;
        bool any = false, differ = false;
        for (unsigned s = 3; s-- > 0;) {
            const std::uint32_t other = base.beyond(f, s).face;
            if (other >= f) continue;
            differ |= any && labels[other] != predicted;
            any = true;
            predicted = labels[other];
        }
        const std::uint32_t truth = labels[f];
        labels[f] = predicted;
        if (coder.code(same[differ ? 1 : 0], truth == predicted)) continue;
        std::size_t at = 0, passed = 0;
        for (; at < latest.size(); ++at)
            if (latest[at] != predicted && coder.code(is_it[passed++], latest[at] == truth)) break;
        if (at == latest.size()) {
            std::uint32_t label = 0;
            for (unsigned bit = 32; bit-- > 0;) {
                AdaptiveBit even;  // a fresh one: both values equally likely
                label = label << 1 | static_cast<std::uint32_t>(coder.code(even, (truth >> bit & 1) != 0));
            }
            if (latest.size() == kLatestLabels) latest.pop_back();
            latest.push_back(label);
            at = latest.size() - 1;
        }
        labels[f] = latest[at];
        std::rotate(latest.begin(), latest.begin() + std::ptrdiff_t(at), latest.begin() + std::ptrdiff_t(at) + 1);
    }
}

}  // namespace mvw
