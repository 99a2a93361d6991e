// Rounds of vertex splits: which decisions are coded, and in which order. Encoder and decoder run this same code, one
// with the truth at hand, the other with the answers of the range decoder. After R. Pajarola and J. Rossignac,
// Compressed Progressive Meshes (2000): in each round every vertex may be split, none beside another.
//
// Coordinates of models of machined parts repeat: a new vertex often has those of its neighbours, and when the lattice
// becomes finer, what lay in one plane stays in one.
#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "codec/entropy/lattice_cells.h"
#include "codec/entropy/model_coder.h"
#include "codec/entropy/progressive_mesh.h"

namespace mvw {

/// A split, and what it leads to.
struct SplitTruth {
    Split split;
    std::array<GridPoint, 2> at{};             // where the vertex and the new one lie
    std::array<std::uint32_t, 2> materials{};  // of the new faces
};

/// Coder   derives from Bits, as ModelCoder wants them
///         bool stopped(): whether the last bit is not known: it and all later ones are of no use
///         GridPoint refined(vertex): where it lies on the new lattice, when encoding
///         std::optional<SplitTruth> split(vertex, ring): when encoding
template <typename Coder>
class SplitCoder : ModelCoder<typename Coder::Bits> {
    using Bits = ModelCoder<typename Coder::Bits>;

 public:
    /// most_vertices: rounds end there.
    SplitCoder(ProgressiveMesh& mesh, std::uint32_t most_vertices, Coder& coder)
        : Bits(coder),
          coder_(coder),
          mesh_(mesh.mesh),
          at_(mesh.at),
          state_(mesh),
          model_(mesh.model),
          most_vertices_(most_vertices) {}

    /// One round, its vertices on `lattice`. False where the bits end or make no mesh: what was done until then is
    /// whole.
    bool run(const Lattice& lattice) {
        if (!(lattice == at_.lattice) && !refine(lattice)) return false;
        const std::uint32_t V = mesh_.vertex_count();
        measure_edges();
        beside_split_.assign(V, 0);
        for (std::uint32_t v = 0; v < V && mesh_.vertex_count() < most_vertices_; ++v)
            if (beside_split_[v] == 0 && look_at(v) && !pass(v)) return false;
        state_.fresh = V;
        return true;
    }

 private:
    using Bits::code;
    using Model = SplitModel;
    enum NumberKind : std::size_t { Within, Across, Moved };
    static constexpr unsigned kMostLength = kMostSplitBits + 4;

    AdaptiveBit& bit(std::size_t index) { return model_.bits[index]; }
    [[nodiscard]] const GridPoint& neighbor(std::size_t m) const { return at_.grid[ring_.neighbor[ring_.place(m)]]; }
    [[nodiscard]] Vec3 point(std::uint32_t v) const { return at_.lattice.in_units(at_.grid[v]); }

    /// Which cell of a finer lattice each vertex lies in: often the one that neighbours of the same coordinate have
    /// gone to.
    bool refine(const Lattice& to) {
        const Rounded old = std::exchange(at_, Rounded{to, {}});
        for (const GridPoint& k : old.grid) at_.grid.push_back(to.nearest(old.lattice.point(k)));
        for (std::uint32_t v = 0; v < old.grid.size(); ++v) {
            const GridPoint truth = coder_.refined(v);
            (void)mesh_.ring(v, ring_);
            for (std::size_t a = 0; a < 3; ++a) {
                const LatticeCells cells(old.lattice, to, a, old.grid[v][a]);
                at_.grid[v][a] = code_cell(cells, guess(v, a, old.grid), truth[a]);
            }
            if (!coder_.stopped()) continue;
            for (; v < old.grid.size(); ++v) state_.unrefined.push_back(to_float(old.lattice.point(old.grid[v])));
            return false;
        }
        return true;
    }
    /// Where a coordinate may have gone, and how many neighbours, of those whose coordinate was the same, have gone
    /// there: up to 3; 0: no guess.
    struct Guess {
        std::int32_t cell = 0;
        std::size_t votes = 0;
    };
    [[nodiscard]] Guess guess(std::uint32_t v, std::size_t a, const std::vector<GridPoint>& old) const {
        Guess out;
        for (std::size_t m = 0; m < ring_.neighbors; ++m) {
            const std::uint32_t n = ring_.neighbor[m];
            if (n >= v || old[n][a] != old[v][a]) continue;
            const std::int32_t cell = at_.grid[n][a];
            if (out.votes == 0 || (out.votes == 1 && cell != out.cell))
                out = {cell, 1};
            else if (cell == out.cell)
                out.votes = std::min<std::size_t>(out.votes + 1, 3);
        }
        return out;
    }
    /// Where no guess holds, each is as likely as what of it lies in the coarser cell.
    std::int32_t code_cell(const LatticeCells& cells, const Guess& guess, std::int32_t truth) {
        if (cells.first() == cells.last()) return cells.first();
        truth = std::clamp(truth, cells.first(), cells.last());
        const bool guessed = guess.votes > 0 && cells.first() <= guess.cell && guess.cell <= cells.last();
        if (guessed && code(bit(Model::kRefined + guess.votes - 1), truth == guess.cell)) return guess.cell;
        const auto share = [&](std::int32_t k) { return guessed && k == guess.cell ? 0 : cells.share(k); };
        std::int32_t last = cells.last();
        if (guessed && last == guess.cell) --last;
        double left = 0;
        for (std::int32_t k = cells.first(); k <= last; ++k) left += share(k);
        for (std::int32_t k = cells.first(); k < last; ++k) {
            if (guessed && k == guess.cell) continue;
            constexpr double kLeast = 0.001;
            const double likely = left > 0 ? std::clamp(share(k) / left, kLeast, 1 - kLeast) : 0.5;
            if (coder_.code(static_cast<std::uint32_t>(likely * (1u << kProbabilityBits)), truth == k)) return k;
            left -= share(k);
        }
        return last;
    }

    void measure_edges() {
        double sum = 0;
        for (const Face& f : mesh_.faces())
            for (std::size_t k = 0; k < 3; ++k) sum += squared_length(point(f[k]) - point(f[(k + 1) % 3]));
        mean_square_ = std::max(sum / (3 * static_cast<double>(mesh_.faces().size())), 1e-9);
    }

    /// The surroundings of a vertex. False where it has too many faces.
    bool look_at(std::uint32_t v) {
        if (!mesh_.ring(v, ring_)) return false;
        const Vec3 center = point(v);
        const std::size_t k = ring_.faces;
        for (std::size_t m = 0; m < ring_.neighbors; ++m) sides_[m] = point(ring_.neighbor[m]) - center;
        for (std::size_t m = 0; m < k; ++m) normals_[m] = cross(sides_[m], sides_[ring_.place(m + 1)]);
        double square = 0;
        sharp_ = worst_ = 0;
        for (std::size_t m = 0; m < ring_.neighbors; ++m) {
            square += squared_length(sides_[m]);
            const bool inner = ring_.closed || (m > 0 && m < k);
            const std::size_t b = inner ? bend(normals_[(m + k - 1) % k], normals_[m % k]) : Model::kBends - 1;
            bends_[m] = static_cast<std::uint8_t>(b);
            sharp_ += b >= 2;
            worst_ = std::max(worst_, b);
        }
        sharp_ = std::min(sharp_, Model::kSharp - 1);
        const double over = square / static_cast<double>(ring_.neighbors) / mean_square_;
        size_ = over < 0.25 ? 0 : over < 1 ? 1 : over < 4 ? 2 : 3;
        return true;
    }
    static std::size_t bend(const Vec3& a, const Vec3& b) {
        const double c = dot(a, b), whole = squared_length(a) * squared_length(b);
        if (whole == 0) return 0;
        if (c <= 0 || 2 * c * c < whole) return 3;
        return c * c > 0.996 * whole ? 0 : c * c > 0.9 * whole ? 1 : 2;
    }
    [[nodiscard]] std::size_t valence() const { return std::clamp<std::size_t>(ring_.faces, 3, 10) - 3; }

    /// Whether a vertex is split, and how. False where the bits end or make no mesh.
    bool pass(std::uint32_t v) {
        const std::optional<SplitTruth> truth = coder_.split(v, ring_);
        const std::size_t fresh = v >= state_.fresh ? 1 : 0;
        const bool splits = code(bit(Model::kSplit + (fresh * Model::kBends + worst_) * Model::kSizes + size_),
                                 bit(Model::kSplitOther + valence() * Model::kSharp + sharp_),
                                 model_.weights[Model::kSplitWeights], truth.has_value());
        if (coder_.stopped()) return false;
        if (!splits) return true;
        SplitTruth made;
        made.split.vertex = v;
        if (!code_cut(truth ? truth->split : Split{}, made.split)) return false;
        if (truth && !(made.split == truth->split)) return false;  // what it is told is no split of this ring
        if (!code_positions(made.split, truth.value_or(made).at, made.at)) return false;
        for (unsigned side = 0; side < (made.split.boundary ? 1u : 2u); ++side)
            made.materials[side] = code_material(made.split, side, truth ? truth->materials[side] : 0);
        if (coder_.stopped()) return false;
        for (std::size_t m = 0; m < ring_.neighbors; ++m)
            if (ring_.neighbor[m] < beside_split_.size()) beside_split_[ring_.neighbor[m]] = 1;
        mesh_.split(ring_, made.split, made.materials);
        at_.grid[v] = made.at[0];
        at_.grid.push_back(made.at[1]);
        return true;
    }

    /// How many faces the new vertex takes over, then from where on.
    bool code_cut(const Split& truth, Split& out) {
        const std::size_t k = ring_.faces;
        out.boundary = !ring_.closed && code(bit(Model::kBoundary), truth.boundary);
        if (!out.boundary) {
            out.taken = 1;
            const std::size_t most = ring_.closed ? k - 1 : k;
            const std::size_t set = Model::kTaken + valence() * Model::kTakes;
            while (out.taken < most &&
                   code(bit(set + std::min<std::size_t>(out.taken, Model::kTakes) - 1), truth.taken > out.taken))
                ++out.taken;
        }
        rank_places(out);
        for (std::size_t rank = 0; rank < places_; ++rank) {
            out.first = ranked_[rank].first;
            if (out.boundary) out.taken = static_cast<std::uint32_t>(k - out.first);
            if (rank + 1 == places_ || code_place(out, rank, truth.first == out.first)) break;
            if (coder_.stopped()) return false;
        }
        return !coder_.stopped() && SplitMesh::is_possible(ring_, out);
    }
    /// Of two vertices that have become one at the place of either, the other one was where most of the ring is.
    void rank_places(Split split) {
        const std::size_t faces = ring_.faces;
        places_ = split.boundary ? faces + 1 : ring_.closed ? faces : faces - split.taken + 1;
        Vec3 middle;
        for (std::size_t m = 0; m < ring_.neighbors; ++m) middle += sides_[m];
        for (split.first = 0; split.first < places_; ++split.first) {
            if (split.boundary) split.taken = static_cast<std::uint32_t>(faces - split.first);
            Vec3 sum;
            for (std::size_t m = split.first; m <= split.first + split.taken; ++m) sum += sides_[ring_.place(m)];
            ranked_[split.first] = {dot(sum, middle) / double(split.taken + 1), split.first};
            for (std::size_t k = split.first; k > 0 && ranked_[k - 1].likely < ranked_[k].likely; --k)
                std::swap(ranked_[k - 1], ranked_[k]);
        }
    }
    bool code_place(const Split& split, std::size_t rank, bool truth) {
        std::size_t inner_sharp = 0, inner_worst = 0;
        for (std::size_t m = split.first + 1; m < split.first + split.taken; ++m) {
            const std::size_t b = bends_[ring_.place(m)];
            inner_sharp += b >= 2;
            inner_worst = std::max(inner_worst, b);
        }
        const auto cut = [&](std::size_t m) { return std::min<std::size_t>(bends_[ring_.place(m)], 2); };
        const std::size_t bends = ((sharp_ * 3 + std::min<std::size_t>(inner_sharp, 2)) * 3 + cut(split.first)) * 3 +
                                  cut(split.first + split.taken);
        const std::size_t left = std::min(places_ - rank, Model::kLefts + 1) - 2;
        const std::size_t place = std::min(rank, Model::kRanks - 1) * Model::kLefts + left;
        return code(bit(Model::kFirst + bends), bit(Model::kFirstOther + place * Model::kBends + inner_worst),
                    model_.weights[Model::kFirstWeights], truth);
    }

    /// Mostly the vertex stays where it was. If not, it moves about as far as the new one, the other way.
    bool code_positions(const Split& split, const std::array<GridPoint, 2>& truth, std::array<GridPoint, 2>& out) {
        const GridPoint& before = at_.grid[split.vertex];
        const std::size_t closed = ring_.closed ? 1 : 0;
        const Fan fan{split.first, split.taken};
        out[0] = before;
        const bool stays = code(bit(Model::kStays + closed * Model::kSharp + sharp_), truth[0] == before);
        if (!code_position(fan, before, truth[1], out[1])) return false;
        const std::size_t scale = this->scale(fan);
        std::size_t size = 0;
        for (std::size_t a = 0; !stays && a < 3; ++a) {
            const std::int64_t expected = 2 * std::int64_t{before[a]} - out[1][a];
            const std::int64_t off = code_number(Moved, scale, size, truth[0][a] - expected, false);
            if (!place(expected + off, out[0][a])) return false;
            size = length_of(off);
        }
        return !coder_.stopped();
    }

    /// Successive faces of the ring. Without any, neighbour `first` alone counts.
    struct Fan {
        std::size_t first = 0, faces = 0;
    };
    /// What is known of a vertex whose neighbours are `anchor` and those of a fan.
    struct Surroundings {
        GridPoint anchor;
        Fan fan;
        Vec3 normal;          // of the fan
        std::size_t axis;     // along which the normal is longest
        std::size_t aligned;  // 1: it runs along that axis
        GridPoint middle;     // mean of the neighbours, of which the anchor counts twice
    };
    [[nodiscard]] Surroundings surroundings(const Fan& fan, const GridPoint& anchor) const {
        Surroundings s{anchor, fan, {}, 0, 0, {}};
        std::array<std::int64_t, 3> sum{};
        for (std::size_t a = 0; a < 3; ++a) sum[a] = std::int64_t{2} * anchor[a];
        for (std::size_t m = fan.first; m <= fan.first + fan.faces; ++m) {
            const GridPoint& p = neighbor(m);
            for (std::size_t a = 0; a < 3; ++a) sum[a] += p[a];
            if (m < fan.first + fan.faces) s.normal += normals_[m % ring_.faces];
        }
        for (std::size_t m = 0; fan.faces == 0 && m < ring_.faces; ++m) s.normal += normals_[m];
        for (std::size_t a = 1; a < 3; ++a)
            if (std::abs(s.normal[a]) > std::abs(s.normal[s.axis])) s.axis = a;
        s.aligned = s.normal[s.axis] * s.normal[s.axis] > 0.999 * squared_length(s.normal) ? 1 : 0;
        const auto count = static_cast<std::int64_t>(fan.faces + 3);
        for (std::size_t a = 0; a < 3; ++a) {
            const std::int64_t top = 2 * sum[a] + count, below = 2 * count;  // to nearest, halves up
            s.middle[a] = static_cast<std::int32_t>(top >= 0 ? top / below : -((-top + below - 1) / below));
        }
        return s;
    }
    /// Along the two axes in which the surface lies, then along the third one, where it is expected in the fan's plane.
    /// One of its neighbours' coordinates, or else so far from what is expected.
    bool code_position(const Fan& fan, const GridPoint& anchor, const GridPoint& truth, GridPoint& out) {
        const Surroundings s = surroundings(fan, anchor);
        const std::size_t scale = this->scale(fan);
        std::size_t equal = 0, size = 0;
        for (std::size_t step = 1; step <= 3; ++step) {
            const std::size_t a = (s.axis + step) % 3;
            const bool across = a == s.axis;
            const std::int32_t expected = across ? in_plane(s, out) : s.middle[a];
            const std::size_t set = ((across ? 1u : 0u) * 2 + s.aligned) * Model::kEqual + equal;
            std::int64_t x = expected;
            if (code_same(s, a, across ? &expected : nullptr, set, truth[a], out[a])) {
                x = out[a];
                ++equal;
            } else {
                const std::int64_t off = code_number(across ? Across : Within, scale, size,
                                                     std::int64_t{truth[a]} - expected, expected < anchor[a]);
                x += off;
                size = length_of(off);
            }
            if (!place(x, out[a])) return false;
            for (std::size_t k = 0; k < unasked_count_; ++k) unasked_[k].same->learn(unasked_[k].guess == out[a]);
        }
        return !coder_.stopped();
    }
    /// Whether the coordinate is that of the plane, where one is given, of the anchor or of the fan's ends. What hardly
    /// ever holds is not asked for.
    bool code_same(const Surroundings& s, std::size_t a, const std::int32_t* plane, std::size_t set, std::int32_t truth,
                   std::int32_t& out) {
        unasked_count_ = 0;
        std::array<std::int32_t, Model::kGuesses> guesses{};
        std::size_t count = 0;
        const auto add = [&](std::int32_t x) { guesses[count++] = x; };
        if (plane) add(*plane);
        add(s.anchor[a]), add(neighbor(s.fan.first)[a]), add(neighbor(s.fan.first + s.fan.faces)[a]);
        for (std::size_t g = 0; g < count; ++g) {
            const std::int32_t x = guesses[g];
            if (std::find(guesses.begin(), guesses.begin() + std::ptrdiff_t(g), x) !=
                guesses.begin() + std::ptrdiff_t(g))
                continue;
            std::size_t votes = 0;
            for (std::size_t m = s.fan.first; m <= s.fan.first + s.fan.faces; ++m) votes += neighbor(m)[a] == x;
            const std::size_t context =
                (set * Model::kGuesses + g) * Model::kVotes + std::min(votes, Model::kVotes - 1);
            AdaptiveBit& same = bit(Model::kSame + context);
            if (same.probability() < Model::kRare) {
                unasked_[unasked_count_++] = {&same, x};
                continue;
            }
            out = x;
            if (code(same, truth == x)) return true;
        }
        return false;
    }
    /// The last coordinate of a point in the plane through the anchor across the normal.
    [[nodiscard]] std::int32_t in_plane(const Surroundings& s, GridPoint point) const {
        const std::size_t n = s.axis, u = (n + 1) % 3, v = (n + 2) % 3;
        if (s.normal[n] == 0) return s.anchor[n];
        point[n] = s.anchor[n];
        const Vec3 off = at_.lattice.in_units(point) - at_.lattice.in_units(s.anchor);
        const double rise = -(s.normal[u] * off[u] + s.normal[v] * off[v]) / s.normal[n];
        constexpr double kMost = 1 << (kMostSplitBits + 2);
        const double cells = std::nearbyint(rise / at_.lattice.cell(n));
        return s.anchor[n] + static_cast<std::int32_t>(std::clamp(cells, -kMost, kMost));
    }
    /// Of the edges to a fan: half the bits of their mean square.
    [[nodiscard]] std::size_t scale(const Fan& fan) const {
        double square = 0;
        for (std::size_t m = fan.first; m <= fan.first + fan.faces; ++m)
            square += squared_length(sides_[ring_.place(m)]);
        constexpr double kMost = 1e12;
        const auto mean = static_cast<std::uint64_t>(std::min(square / double(fan.faces + 1), kMost));
        return std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(mean)) / 2, Model::kScales - 1);
    }
    bool place(std::int64_t x, std::int32_t& out) const {
        out = static_cast<std::int32_t>(x);
        return std::abs(x) <= std::int64_t{2} << at_.lattice.bits;
    }

    static std::size_t length_of(std::int64_t number) {
        const auto length = static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(std::abs(number))));
        return std::min(length, Model::kLengths - 1);
    }
    /// other: length of the number before. turned: below zero it leads away from the anchor.
    std::int64_t code_number(std::size_t kind, std::size_t scale, std::size_t other, std::int64_t truth, bool turned) {
        const std::int64_t size = code_size(kind, scale, other, std::abs(truth));
        return size > 0 && code(bit(Model::kSign + kind), (truth < 0) != turned) != turned ? -size : size;
    }
    std::int64_t code_size(std::size_t kind, std::size_t scale, std::size_t other, std::int64_t truth) {
        AdaptiveBit* const set = &bit(Model::kNumber + kind * Model::kNumberSet);
        return Bits::code_size({&set[scale * Model::kLengths], &set[(Model::kScales + other) * Model::kLengths],
                                &model_.weights[Model::kNumberWeights + kind * Model::kLengths],
                                &bit(Model::kTop + kind * Model::kLengths)},
                               kMostLength, truth);
    }

    /// Of a new face: that of one of the two between which it comes.
    std::uint32_t code_material(const Split& split, unsigned side, std::uint32_t truth) {
        if (mesh_.materials().empty()) return 0;
        const auto [kept, taken] = SplitMesh::beside(ring_, split, side);
        if (kept == kNone) return mesh_.materials()[taken];
        const std::uint32_t a = mesh_.materials()[kept], b = taken == kNone ? a : mesh_.materials()[taken];
        return a == b || code(bit(Model::kMaterial), truth == a) ? a : b;
    }

    Coder& coder_;
    SplitMesh& mesh_;
    Rounded& at_;
    ProgressiveMesh& state_;
    SplitModel& model_;
    const std::uint32_t most_vertices_;
    double mean_square_ = 1;                  // of edges, at the round's begin, in units of the lattice
    std::vector<std::uint8_t> beside_split_;  // of those that were there at the round's begin
    // Around the vertex looked at:
    VertexRing ring_;
    template <typename T>
    using Around = std::array<T, VertexRing::kMostFaces + 1>;
    Around<Vec3> sides_, normals_;  // to the neighbours; of the faces, of twice their area
    Around<std::uint8_t> bends_;    // at the edges
    struct Place {
        double likely;
        std::uint32_t first;
    };
    Around<Place> ranked_;  // of a cut, the likeliest first
    std::size_t places_ = 0;
    struct Unasked {
        AdaptiveBit* same;
        std::int32_t guess;
    };
    std::array<Unasked, Model::kGuesses> unasked_;  // of the coordinate looked at
    std::size_t unasked_count_ = 0;
    std::size_t sharp_ = 0, worst_ = 0, size_ = 0;
};

}  // namespace mvw
