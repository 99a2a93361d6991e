#include "codec/enc_splits.h"

#include <cassert>

namespace mvw {

namespace {

/// The end of the collapsed edge that keeps its number when it is split again: what lies on a boundary, the one whose
/// edge along it runs to the other; else the one that has stayed where it was.
std::uint32_t keeper(const Collapse& c) {
    if (c.right == kNone) return c.to;
    if (c.on_boundary[0] != c.on_boundary[1]) return c.on_boundary[0] ? c.from : c.to;
    return c.before[1] == c.after ? c.removed : c.kept;
}

}  // namespace

void SplitSource::begin_round(const std::vector<Collapse>& collapses, const Lattice& lattice) {
    lattice_ = lattice;
    undone_.clear();
    for (const Collapse& c : collapses) undone_.emplace(c.kept, &c);
}

void SplitSource::end_round() {
    for (const auto& [name, c] : undone_) positions_[c->kept] = c->before[0], positions_[c->removed] = c->before[1];
    for (const auto& [number, name] : renamed_) names_[number] = name;
    names_.insert(names_.end(), added_.begin(), added_.end());
    renamed_.clear();
    added_.clear();
}

std::uint32_t SplitSource::place_of(std::uint32_t name, const VertexRing& ring) const {
    std::uint32_t m = 0;
    while (m < ring.neighbors && names_[ring.neighbor[m]] != name) ++m;
    assert(m < ring.neighbors);
    return m;
}

std::optional<SplitTruth> SplitSource::split(std::uint32_t v, const VertexRing& ring) {
    const auto found = undone_.find(names_[v]);
    if (found == undone_.end()) return std::nullopt;
    const Collapse& c = *found->second;
    const std::uint32_t keeps = keeper(c), other = keeps == c.kept ? c.removed : c.kept;
    // The face left of the half-edge from the new vertex to the other one comes first.
    const bool forward = c.from == other;
    SplitTruth out;
    out.split.vertex = v;
    out.split.boundary = c.right == kNone;
    out.split.first = place_of(forward ? c.left : c.right, ring);
    const auto faces = static_cast<std::uint32_t>(ring.faces);
    const std::uint32_t end = out.split.boundary ? faces : place_of(forward ? c.right : c.left, ring);
    out.split.taken = end >= out.split.first ? end - out.split.first : end + faces - out.split.first;
    out.materials = forward ? c.materials : std::array<std::uint32_t, 2>{c.materials[1], c.materials[0]};
    for (std::size_t k = 0; k < 2; ++k)
        out.at[k] = lattice_.nearest(c.before[(k == 0 ? keeps : other) == c.kept ? 0 : 1]);
    renamed_.emplace_back(v, keeps);
    added_.push_back(other);
    return out;
}

}  // namespace mvw
