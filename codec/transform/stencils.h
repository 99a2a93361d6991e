// Prediction stencils of every transform, as data: what an edge's new vertex is predicted from, by rule and by the
// edge's neighbourhood. Sources: Jiang, Li, Zhu (matrix-valued interpolatory Loop subdivision), the paper's equations
// (7) to (9), Zorin et al. (modified butterfly), Loop; README.md of this folder gives them in one place.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/transform/level.h"
#include "codec/transform/transform.h"

namespace mvw {

/// Weights of the ten points of an ordinary edge, by class. Order of the class everywhere: ends, opp, wings, far.
struct TenWeights {
    double ends = 0, opp = 0, wings = 0, far = 0;
};

// First components of the matrix masks J, K, M, N: weights of the positions ...
inline constexpr TenWeights kInterpPosition{31.0 / 72, 7.0 / 72, -1.0 / 144, -1.0 / 72};
// ... and of the shape components x (M's lower left entry is -1/72: the paper's sign is a misprint).
inline constexpr TenWeights kInterpShape{13.0 / 36, 7.0 / 36, -1.0 / 72, -1.0 / 36};
// Second component of the odd rule on [v, 0], for the transform that keeps both.
inline constexpr TenWeights kVectorShape{-1.0 / 36, 1.0 / 72, 1.0 / 288, 1.0 / 144};
inline constexpr TenWeights kButterflyPosition{1.0 / 2, 1.0 / 8, -1.0 / 16, 0};
inline constexpr TenWeights kLoopPosition{3.0 / 8, 1.0 / 8, 0, 0};
// The vector transform's x' at a vertex: 3/8 (v - mean of its ring); alpha/16 at an extraordinary one, alpha = 64/29.
inline constexpr double kVectorEven = 3.0 / 8, kVectorEvenIrregular = 4.0 / 29;
/// Table 1 of the paper, in our class order.
inline constexpr TenWeights kTable1{-0.17712, -0.0016, 0.0249, 0.0238};

/// The rules behind the transforms; SeededNormal differs from Seeded at extraordinary vertices (s = 1) and on sharp
/// edges, and is projected by its caller.
enum class PredictRule : std::uint8_t { Interp, Loop, Butterfly, Seeded, SeededNormal };
PredictRule predict_rule(TransformKind kind);
bool is_lazy(TransformKind kind);

/// One term of a prediction: position weight and weight of the estimated shape component x (Seeded rules only).
struct Term {
    std::uint32_t vertex;
    double position, shape;
};

/// P(e) as a sum of terms (a vertex may repeat), appended to `out`:
///   sharp edge              1/2 each end; Butterfly, Seeded*: the 4-point rule along the curve, where it goes on
///   an end is sharp         1/2 each end; Seeded*: plus x of the end that is not
///   an end is irregular     31s/72 ends + (1/2 - 31s/72) opp; Seeded*: plus 1/4 of the four x; Butterfly: Zorin's,
///                           where an end has more than 32 edges 1/2 each end
///   ordinary                the ten points
/// Loop has two cases: sharp 1/2 each end, else 3/8 and 1/8.
void predict_terms(const Level& level, std::uint32_t edge, PredictRule rule, double s, std::vector<Term>& out);

/// x = (v - mean of its ring)/4, -(h^2/16) Laplacian on quadratics: the neighbours whose mean is meant. On a curve
/// those along it; empty at a corner, where x = 0. Replaces `out`.
void shape_neighbours(const Level& level, std::uint32_t v, std::vector<std::uint32_t>& out);

/// Loop's rule of an even vertex in lifting form: v' = a v + b sum of e' over its edges (on a curve: over the curve's
/// two; at a corner a = 1, b = 0).
struct LoopEven {
    double a, b;
};
LoopEven loop_even(std::size_t valence, bool sharp, bool on_curve);
LoopEven loop_even(const Level& level, std::uint32_t v);
/// The edges that rule sums over. Replaces `out`.
void loop_edges(const Level& level, std::uint32_t v, std::vector<std::uint32_t>& out);

}  // namespace mvw
