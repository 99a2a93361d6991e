// The oracle: every transform on explicit connectivity, in double precision, slow and obvious. Tests compare the
// production grid (transform.h) with it; nothing else runs on it.
#pragma once
#include <span>
#include <vector>

#include "codec/mesh/semi_regular.h"
#include "codec/transform/lifting.h"
#include "codec/transform/transform.h"

namespace mvw {

/// Forward and inverse transform; arrays as in PatchTransform (hierarchical order, details in frames or model axes).
///
/// One level of synthesis, v of level j and d the details of level j + 1:
///   1  d to model axes, by frames of v as it arrives
///   2  v += sum of w d                    undo the lift
///   3  e' = d + P(v)                      undo the prediction
///   4  Loop only: v' = a v + b sum of e'
/// Analysis is the same backwards. Seeded rules estimate x = (v - mean of ring)/4 from the v of step 3; SeededNormal
/// takes x along the vertex normals of that v and moves the midpoint along the edge's normal only, sharp edges
/// excepted.
class ReferenceTransform {
 public:
    ReferenceTransform(const BaseMesh& base, unsigned levels, const TransformOptions& options,
                       std::span<const std::uint8_t> creases = {});

    /// positions: V(L), in. coefficients: V(L), out. shape: empty, or V(L) second components of the Vector transform,
    /// in the same order, in model axes, out (x = 0 on the finest level).
    void analyze(std::span<const Vec3> positions, std::span<Vec3> coefficients, std::span<Vec3> shape = {}) const;
    /// coefficients: at least V(level), in. positions: V(level), out. shape: empty, or V(level) second components, in
    /// as coefficients and out as values of the finest level.
    void synthesize(std::span<const Vec3> coefficients, unsigned level, std::span<Vec3> positions,
                    std::span<Vec3> shape = {}) const;

 private:
    struct Step {
        Level level;
        std::vector<std::size_t> first_term, first_lift;  // E + 1 each, by edge
        std::vector<Term> terms;
        std::vector<LiftTerm> lifts;
    };
    void add_step(const BaseMesh& base, unsigned j, std::span<const std::uint8_t> creases);
    void lift(const Step& step, std::span<Vec3> v, double sign) const;
    void predict(const Step& step, std::span<Vec3> v, double sign) const;
    void loop_even(const Step& step, std::span<Vec3> v, bool forward) const;
    void vector_even(const Step& step, std::span<const Vec3> v, std::span<Vec3> x, double sign) const;
    void vector_odd(const Step& step, std::span<const Vec3> v, std::span<Vec3> x, double sign) const;

    TransformOptions options_;
    std::vector<Step> steps_;
};

}  // namespace mvw
