// Encodes rounds of vertex splits that undo a simplifier's collapses.
#pragma once
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "codec/entropy/enc_bits.h"
#include "codec/entropy/split_coder.h"
#include "codec/remesh/simplify.h"

namespace mvw {

/// What a SplitCoder asks for when encoding. Vertices have names beside their numbers: those of the simplified mesh.
class SplitSource : public EncodedBits {
 public:
    /// names: of the vertices of a decoder's coarse mesh. positions: of all names, as they are in it.
    SplitSource(std::vector<std::uint32_t> names, std::vector<Vec3> positions)
        : names_(std::move(names)), positions_(std::move(positions)) {}

    /// collapses: what the round is to undo; outlives it.
    void begin_round(const std::vector<Collapse>& collapses, const Lattice& lattice);
    void end_round();

    [[nodiscard]] GridPoint refined(std::uint32_t v) const { return lattice_.nearest(positions_[names_[v]]); }
    std::optional<SplitTruth> split(std::uint32_t v, const VertexRing& ring);

    [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }
    [[nodiscard]] const std::vector<std::uint32_t>& names() const { return names_; }

 private:
    [[nodiscard]] std::uint32_t place_of(std::uint32_t name, const VertexRing& ring) const;

    std::vector<std::uint32_t> names_;  // by number
    std::vector<Vec3> positions_;       // by name
    Lattice lattice_;
    std::unordered_map<std::uint32_t, const Collapse*> undone_;     // by the name that was kept
    std::vector<std::pair<std::uint32_t, std::uint32_t>> renamed_;  // numbers and names
    std::vector<std::uint32_t> added_;                              // names of new numbers
};

}  // namespace mvw
