// A mesh on a grid, triangle by triangle: which decisions are coded, and in which order. Encoder and decoder run this
// same code, one with the truth at hand, the other with the answers of the range decoder.
//
// Connectivity and positions are coded together: where a triangle goes shows in the angles of what is there, and a new
// vertex is expected where the triangle across its gate and the border's next vertices point.
#pragma once
#include <algorithm>
#include <bit>
#include <cstdlib>
#include <vector>

#include "codec/entropy/mesh_model.h"
#include "codec/entropy/model_coder.h"

namespace mvw {

/// What lies beyond a gate.
struct BeyondGate {
    enum Kind : std::uint8_t { Nothing, Vertex, FillAfter, FillBefore, Join } kind = Nothing;
    std::uint32_t other = 0;  // Join: the node, or kNoNode where the surface touches itself and cannot be coded so
};

/// Coder   derives from Bits, as ModelCoder wants them
///         BeyondGate beyond(growth, gate): when encoding
///         GridPoint position(vertex): when encoding; called once for each vertex, in order
template <typename Coder>
class MeshCoder : ModelCoder<typename Coder::Bits> {
    using Bits = ModelCoder<typename Coder::Bits>;

 public:
    MeshCoder(std::uint32_t vertices, std::uint32_t faces, bool has_boundary, unsigned bits, MeshModel& model,
              Coder& coder)
        : Bits(coder),
          coder_(coder),
          vertices_(vertices),
          faces_(faces),
          has_boundary_(has_boundary),
          bits_(bits),
          model_(model) {}

    /// False where the decisions make no mesh of these counts on this grid.
    bool run() {
        while (growth_.faces().size() < faces_) {
            std::uint32_t gate = 0;
            if (growth_.next_gate(gate) ? !pass(gate) : !start()) return false;
        }
        return positions_.size() == vertices_;
    }
    [[nodiscard]] const std::vector<Face>& faces() const { return growth_.faces(); }
    [[nodiscard]] const std::vector<GridPoint>& positions() const { return positions_; }
    std::vector<Face> take_faces() { return growth_.take_faces(); }
    std::vector<GridPoint> take_positions() { return std::move(positions_); }

 private:
    using Bits::code, Bits::code_plain;

    static constexpr unsigned kMostLength = kMaxMeshBits + 4;

    static std::size_t turns(std::size_t angle) { return angle / 2; }
    [[nodiscard]] std::size_t valence(std::uint32_t node) const {
        const unsigned v = growth_.valence(growth_.node(node).vertex);
        return std::clamp(v, 2u, 7u) - 2;
    }
    bool fill(std::size_t side, std::size_t gap, std::size_t other_gap, std::size_t valence, std::size_t length,
              bool truth) {
        AdaptiveBit* const bits = &model_.bits[MeshModel::kFill + side * MeshModel::kFillSet];
        return code(bits[gap * MeshModel::kTurns + turns(other_gap)],
                    bits[MeshModel::kAngles * MeshModel::kTurns + valence * MeshModel::kLengths + length],
                    model_.weights[MeshModel::kFillWeights + side], truth);
    }

    /// What is beyond the gate, and the mesh grown by it.
    bool pass(std::uint32_t gate) {
        const GateView view(growth_, positions_, bits_, gate);
        const BeyondGate truth = coder_.beyond(growth_, gate);
        const std::uint32_t end = growth_.next(gate);
        if (has_boundary_) {
            const std::size_t closed =
                std::size_t{growth_.node(growth_.previous(gate)).closed} + std::size_t{growth_.node(end).closed} * 2;
            if (code(model_.bits[MeshModel::kBoundary + closed], truth.kind == BeyondGate::Nothing)) {
                growth_.close(gate);
                return true;
            }
        }
        if (growth_.can_fill(end) && fill(0, view.gap_at_end(), view.gap_at_start(), valence(end), view.closing_after(),
                                          truth.kind == BeyondGate::FillAfter)) {
            growth_.fill_after(gate);
            return true;
        }
        if (growth_.can_fill(gate) && fill(1, view.gap_at_start(), view.gap_at_end(), valence(gate),
                                           view.closing_before(), truth.kind == BeyondGate::FillBefore)) {
            growth_.fill_before(gate);
            return true;
        }
        const std::size_t narrow = turns(std::min(view.gap_at_start(), view.gap_at_end()));
        if (positions_.size() < vertices_ &&
            code(model_.bits[MeshModel::kVertex + narrow * MeshModel::kTouches + view.touch()],
                 truth.kind == BeyondGate::Vertex)) {
            return add_vertex(view, gate);
        }
        if (truth.other == kNoNode) return false;
        const std::uint32_t other = code_node(view, truth.other);
        if (other >= growth_.nodes().size() || !growth_.node(other).alive || other == gate) return false;
        growth_.join(gate, other);
        return true;
    }

    /// Mostly the nearest one; else its number.
    std::uint32_t code_node(const GateView& view, std::uint32_t truth) {
        if (view.nearest() != kNoNode && code(model_.bits[MeshModel::kNearest + view.touch()], truth == view.nearest()))
            return view.nearest();
        const auto last = static_cast<std::uint32_t>(growth_.nodes().size() - 1);
        return code_plain(truth, static_cast<unsigned>(std::bit_width(last)));
    }

    bool start() {
        if (positions_.size() + 3 > vertices_) return false;
        growth_.start();
        GridPoint from{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto v = static_cast<std::uint32_t>(positions_.size());
            const GridPoint truth = coder_.position(v);
            GridPoint p{};
            for (unsigned axis = 0; axis < 3; ++axis) {
                const std::int64_t r = code_number(0, MeshModel::kScales - 1, MeshModel::kSpreads - 1,
                                                   std::int64_t{truth[axis]} - from[axis]);
                if (!place(from[axis] + r, p[axis])) return false;
            }
            positions_.push_back(p);
            moved_.push_back({{MeshModel::kSpreads - 1, MeshModel::kSpreads - 1}, 0});
            from = p;
        }
        return true;
    }

    bool add_vertex(const GateView& view, std::uint32_t gate) {
        const std::uint32_t a = view.around()[0], b = view.around()[1];
        const GridPoint& expected = view.prediction();
        growth_.add_vertex(gate);
        const GridPoint truth = coder_.position(static_cast<std::uint32_t>(positions_.size()));
        const unsigned n = view.axis(), u = (n + 1) % 3, v = (n + 2) % 3;
        GridPoint p{};
        const auto spread = [&](unsigned kind) {
            return (moved_[a].spread[kind] + moved_[b].spread[kind] + std::size_t{1}) / 2;
        };
        const std::int64_t ru = code_number(0, view.scale(), spread(0), std::int64_t{truth[u]} - expected[u]);
        const std::int64_t rv = code_number(0, view.scale(), spread(0), std::int64_t{truth[v]} - expected[v]);
        if (!place(expected[u] + ru, p[u]) || !place(expected[v] + rv, p[v])) return false;
        const std::int64_t level = expected[n] + view.in_plane(ru, rv);
        const int sign = view.faces_down() ? -1 : 1;
        const std::int64_t rn =
            code_bend(view.scale(), spread(1), moved_[a].bend + moved_[b].bend, sign * (truth[n] - level));
        if (!place(level + sign * rn, p[n])) return false;
        positions_.push_back(p);
        moved_.push_back(
            {{spread_of(std::abs(ru) + std::abs(rv), view.scale()), spread_of(2 * std::abs(rn), view.scale())},
             static_cast<std::int8_t>((rn > 0) - (rn < 0))});
        return true;
    }
    bool place(std::int64_t x, std::int32_t& out) const {
        out = static_cast<std::int32_t>(x);
        return std::abs(x) <= std::int64_t{1} << bits_;
    }
    /// Of a residual (the sum of two) against the gate's length.
    static std::uint8_t spread_of(std::int64_t sum, std::size_t scale) {
        const std::int64_t unit = std::int64_t{1} << (scale / 2);
        std::uint8_t k = 0;
        while (k + 1u < MeshModel::kSpreads && sum * 8 > unit) sum /= 2, ++k;
        return k;
    }

    std::int64_t code_number(std::size_t kind, std::size_t scale, std::size_t spread, std::int64_t truth) {
        const std::int64_t size = code_size(kind, scale, spread, std::abs(truth));
        return size > 0 && code_plain(truth < 0, 1) != 0 ? -size : size;
    }
    /// A residual across the surface; bend: sum of the signs of two neighbours' ones.
    std::int64_t code_bend(std::size_t scale, std::size_t spread, int bend, std::int64_t truth) {
        const std::int64_t size = code_size(1, scale, spread, std::abs(truth));
        if (size == 0) return 0;
        AdaptiveBit& bit = model_.bits[MeshModel::kSign + static_cast<std::size_t>(std::abs(bend))];
        const bool towards = code(bit, (truth < 0) == (bend < 0));
        return towards == (bend < 0) ? -size : size;
    }

    std::int64_t code_size(std::size_t kind, std::size_t scale, std::size_t spread, std::int64_t truth) {
        AdaptiveBit* const bits = &model_.bits[MeshModel::kSize + kind * MeshModel::kSizeSet];
        return Bits::code_size(
            {&bits[scale * MeshModel::kSizes], &bits[(MeshModel::kScales + spread) * MeshModel::kSizes],
             &model_.weights[MeshModel::kSizeWeights + kind * MeshModel::kSizes],
             &model_.bits[MeshModel::kTop + kind * MeshModel::kSizes]},
            kMostLength, truth);
    }

    Coder& coder_;
    const std::uint32_t vertices_, faces_;
    const bool has_boundary_;
    const unsigned bits_;
    MeshModel& model_;
    MeshGrowth growth_;
    std::vector<GridPoint> positions_;
    /// A vertex' residual: classes of its length within the surface and across it, and the latter's sign.
    struct Moved {
        std::array<std::uint8_t, MeshModel::kKinds> spread;
        std::int8_t bend;
    };
    std::vector<Moved> moved_;
};

}  // namespace mvw
