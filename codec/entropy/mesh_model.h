// In which context each decision about a growing mesh is coded, what is predicted of a new vertex, and the adaptive
// state. Integers only: all platforms must see the same.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/entropy/adaptive_bit.h"
#include "codec/entropy/mesh_growth.h"
#include "codec/mesh/lattice.h"

namespace mvw {

/// Grids of more bits are not coded so: products below have to fit 64 bits.
inline constexpr unsigned kMaxMeshBits = 24;

/// Adaptive state; begins as trained.
struct MeshModel {
    static constexpr std::size_t kAngles = 10, kTurns = 5, kValences = 6, kLengths = 5, kTouches = 6, kScales = 20,
                                 kSpreads = 6, kSizes = 12, kBends = 3;
    static constexpr std::size_t kKinds = 2;  // of residuals: within the surface, across it
    static constexpr std::size_t kBoundary = 0, kFill = kBoundary + 4,
                                 kFillSet = kAngles * kTurns + kValences * kLengths, kVertex = kFill + 2 * kFillSet,
                                 kNearest = kVertex + kTurns * kTouches, kSize = kNearest + kTouches,
                                 kSizeSet = (kScales + kSpreads) * kSizes, kTop = kSize + kKinds * kSizeSet,
                                 kSign = kTop + kKinds * kSizes, kBits = kSign + kBends;
    static constexpr std::size_t kFillWeights = 0, kSizeWeights = 2, kWeights = kSizeWeights + kKinds * kSizes;

    MeshModel();
    /// Another start than the trained one, in the units of mesh_priors.h: what training itself needs.
    MeshModel(const std::array<std::int8_t, kBits>& logits, const std::array<std::int8_t, 2 * kWeights>& mixing);

    std::array<AdaptiveBit, kBits> bits;
    std::array<MixWeights, kWeights> weights;
};

/// What is known around a gate, from the positions of the vertices so far.
class GateView {
 public:
    /// bits: of the grid.
    GateView(const MeshGrowth& growth, const std::vector<GridPoint>& positions, unsigned bits, std::uint32_t gate);

    /// The gap at a node, from its edge round to the one before it: a class below MeshModel::kAngles, the last two of
    /// them over half a turn.
    [[nodiscard]] std::size_t gap_at_start() const { return gap_at_start_; }
    [[nodiscard]] std::size_t gap_at_end() const { return gap_at_end_; }
    /// Length of what a filling triangle would add, over that of the gate: a class below MeshModel::kLengths.
    [[nodiscard]] std::size_t closing_after() const { return closing_after_; }
    [[nodiscard]] std::size_t closing_before() const { return closing_before_; }

    /// Where a new vertex is expected, in grid units: a sum of what is around, less the middle of the gate.
    [[nodiscard]] const GridPoint& prediction() const { return prediction_; }
    /// Which row of kMeshPrediction that comes from: how wide the gaps are.
    [[nodiscard]] std::size_t prediction_class() const { return wide(gap_at_start_) * 4 + wide(gap_at_end_); }
    /// Vertices: the gate's ends, the inner one, the ring's one before the gate and the one behind it.
    [[nodiscard]] const std::array<std::uint32_t, 5>& around() const { return around_; }
    /// The node nearest to prediction() of those not far along the ring, kNone where there is none, and its distance
    /// over the gate's length: a class below MeshModel::kTouches.
    [[nodiscard]] std::uint32_t nearest() const { return nearest_; }
    [[nodiscard]] std::size_t touch() const { return touch_; }
    /// Class of the gate's length, below MeshModel::kScales.
    [[nodiscard]] std::size_t scale() const { return scale_; }
    /// The axis that is nearest to the surface's normal: coded last.
    [[nodiscard]] unsigned axis() const { return axis_; }
    /// What the plane at the gate expects of a residual along axis(), given those along the next two axes, u and v.
    [[nodiscard]] std::int64_t in_plane(std::int64_t u, std::int64_t v) const;
    /// Whether outwards is towards lower coordinates along axis().
    [[nodiscard]] bool faces_down() const { return normal_[axis_] < 0; }

 private:
    using Wide = std::array<std::int64_t, 3>;

    static std::size_t wide(std::size_t gap) { return gap < 5 ? 0 : gap < 7 ? 1 : gap < 8 ? 2 : 3; }
    void predict();
    void find_nearest(const MeshGrowth& growth, std::uint32_t gate, std::uint64_t length);

    const std::vector<GridPoint>& positions_;
    std::uint32_t nearest_ = kNoNode;
    std::size_t touch_ = 0;
    std::array<std::uint32_t, 5> around_{};  // vertices: gate's ends, inner, before, behind
    GridPoint prediction_{};
    Wide normal_{};
    std::size_t gap_at_start_ = 0, gap_at_end_ = 0, closing_after_ = 0, closing_before_ = 0, scale_ = 0;
    unsigned axis_ = 0;
};

}  // namespace mvw
