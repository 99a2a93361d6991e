// The wavelet transforms by name, and the production entry points. What each does is in math.md's terms beside the
// stencils; reference/ holds the oracle, patch/ the grid that this runs on.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codec/mesh/semi_regular.h"
#include "codec/vec.h"

namespace mvw {

/// On disk (FORMAT.md): append values, never renumber.
enum class TransformKind : std::uint8_t {
    Interp = 0,
    InterpLazy = 1,
    Vector = 2,  // no file carries its second component
    Loop = 3,
    LoopLazy = 4,
    Butterfly = 5,
    ButterflyLazy = 6,
    Seeded = 7,
    SeededLazy = 8,
    SeededNormal = 9,
    SeededNormalLazy = 10,
};
inline constexpr unsigned kTransformCount = 11;

/// Command-line name ("seeded-normal"), and back.
std::string_view transform_name(TransformKind kind);
std::vector<std::string> transform_names();  // of all
std::optional<TransformKind> transform_from_name(std::string_view name);

struct TransformOptions {
    TransformKind kind = TransformKind::SeededNormal;
    double s = 36.0 / 31.0;       // in (0, 36/31]: shape of the rule at extraordinary vertices
    bool table1_weights = false;  // the paper's published Table 1 instead of the computed weights
    unsigned loop_template = 10;  // lifting template of Loop: 4 or 10
    bool local_frames = true;     // details as (normal, tangent, tangent) of the level below; else model axes
};

/// What one unit of a coefficient moves on the finest level: the L2 norm of its effect, sqrt(sum over vertices of
/// |effect|^2), in a flat regular neighbourhood. A quantiser of step q leaves about q^2/12 gain^2 / V(L) squared error
/// for each coefficient, so that equal slopes ask for steps proportional to 1/gain: about half for each coarser level.
struct LevelGain {
    double normal = 1, tangential = 1;  // equal but for SeededNormal*, which predicts tangentially by the midpoint
};
/// gains[0] of a base vertex, gains[j] of a detail of level j, j = 1 ... levels.
std::vector<LevelGain> synthesis_gains(const TransformOptions& options, unsigned levels);

class TransformTables;

/// Forward and inverse transform of one semi-regular mesh on the patch grid. Set up once, then reusable: no allocation
/// afterwards. All arrays are in hierarchical order; a coefficient array holds V(0) coarse positions, then for each
/// level's new vertices their detail vectors (in local frames or model axes, as the options say).
///
/// One level of synthesis, with v the positions of level j and d the details of level j + 1, in this order:
///   1  d goes from local frames to model axes. Its frame (frames.h) is that of the edge it splits: the normalised sum
///   of
///      the two ends' unit normals, and the edge's direction flattened; both from v as it arrives, before step 2.
///   2  the lift is undone: v += sum of w d (lifting.h)
///   3  the prediction is undone: e' = d + P(v), P and the normals that SeededNormal uses from the v of step 2
///      (stencils.h); SeededNormal: P = m + n n.(Q - m), m the midpoint, n the normalised sum of the ends' unit
///      normals, sharp edges excepted, where P = Q
///   4  Loop only: v' = a v + b sum of e'
/// The direction of an edge is that in which the upright triangle (i,k) (i+1,k) (i,k+1) runs through it; on a base
/// edge, its own.
///
/// Frames come from the surface that the caller of synthesize() has: an open-loop decoder at lower quality uses
/// slightly turned frames, a second-order effect.
class PatchTransform {
 public:
    /// The tables must be made for so many levels; no one may make any while this is at work. updates: keeps what
    /// update() needs, about two thirds of the positions' size.
    PatchTransform(std::shared_ptr<const TransformTables> tables, unsigned levels, unsigned threads = 1,
                   bool updates = false);
    /// With tables of its own. creases: empty, or one flag for each base edge (the boundary rule predicts along those).
    PatchTransform(const BaseMesh& base, unsigned levels, const TransformOptions& options,
                   std::span<const std::uint8_t> creases = {}, unsigned threads = 1, bool updates = false);
    ~PatchTransform();
    PatchTransform(PatchTransform&&) noexcept;
    PatchTransform& operator=(PatchTransform&&) noexcept;

    /// positions: V(L), in. coefficients: V(L), out. second: empty, or (Vector only) V(L) second components in model
    /// axes, out; those of `positions` are zero.
    void analyze(std::span<const Vec3f> positions, std::span<Vec3f> coefficients, std::span<Vec3f> second = {});
    /// coefficients: at least V(level), in. positions: V(level), out. level <= L. second, second_out: the same of the
    /// second component, both or none.
    void synthesize(std::span<const Vec3f> coefficients, unsigned level, std::span<Vec3f> positions,
                    std::span<const Vec3f> second = {}, std::span<Vec3f> second_out = {});

    /// Like synthesize(), where since the last synthesize() or update() to this level coefficients differ only in
    /// details of levels >= first_level, of these base faces: their inner points, and the sides that are theirs
    /// (BaseEdge::face[0]). `positions` must hold the last result. Computes what can differ: the faces' groups of eight
    /// and those around, spreading while bits change. Same bits as synthesize(). Falls back to it where there is
    /// nothing to build on: another level, first_level 0, Loop's rules, or `updates` not asked for.
    void update(std::span<const Vec3f> coefficients, std::span<const std::uint32_t> faces, unsigned first_level,
                unsigned level, std::span<Vec3f> positions);

    /// Bytes that this holds: buffers, and tables, which it may share.
    [[nodiscard]] std::size_t memory_bytes() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mvw
