// Crease bits of base edges and material labels of base faces: contexts that both directions share (FORMAT.md 4.2).
// Coder is the range encoder or decoder behind `bool code(AdaptiveBit&, bool truth)`; a decoder ignores the truth.
#pragma once
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

/// One label for each face in order: that of its neighbour of lowest side among faces before it (else of the face
/// before), or a new one, 32 bits from the top.
template <typename Coder>
void code_materials(const BaseMesh& base, std::vector<std::uint32_t>& labels, Coder& coder) {
    std::array<AdaptiveBit, 1> same;
    for (std::uint32_t f = 0; f < labels.size(); ++f) {
        std::uint32_t predicted = f > 0 ? labels[f - 1] : 0;
        for (unsigned s = 3; s-- > 0;) {
            const std::uint32_t other = base.beyond(f, s).face;
            if (other < f) predicted = labels[other];
        }
        if (coder.code(same[0], labels[f] == predicted)) {
            labels[f] = predicted;
            continue;
        }
        const std::uint32_t truth = labels[f];
        labels[f] = 0;
        for (unsigned bit = 32; bit-- > 0;) {
            AdaptiveBit even;  // a fresh one: both values equally likely
            labels[f] = labels[f] << 1 | static_cast<std::uint32_t>(coder.code(even, (truth >> bit & 1) != 0));
        }
    }
}

}  // namespace mvw
