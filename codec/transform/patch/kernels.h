// The regular rules over one whole patch, vectorised (Google Highway, the best instruction set chosen at run time, its
// portable code elsewhere). Every stencil is a set of constant offsets within a row; weights come as tables.
#pragma once
#include <cstdint>

#include "codec/transform/patch/layout.h"
#include "codec/transform/stencils.h"
#include "codec/vec.h"

namespace mvw {

struct FloatWeights {
    float ends = 0, opp = 0, wings = 0, far = 0;

    FloatWeights() = default;
    explicit FloatWeights(const TenWeights& w)
        : ends(float(w.ends)), opp(float(w.opp)), wings(float(w.wings)), far(float(w.far)) {}
};

/// Pointers are to one patch: v, normals, shape: 3 vertex planes; d: 9 detail planes (component, then H, V, D). Ghosts
/// that a kernel reads must be filled. Listed edges and base vertices come out wrong: their lists put that right.
struct Kernels {
    /// v += sign * sum of w d.
    void (*lift)(const Layout&, const FloatWeights& w, float sign, const float* d, float* v);
    /// d += sign * P(v), P the ten points with `position`; with `shape` not null also the ten of x with
    /// `shape_weights`.
    void (*predict)(const Layout&, const FloatWeights& position, const FloatWeights& shape_weights, float sign,
                    const float* v, const float* shape, float* d);
    /// The same along the normal only: P = m + n n.(Q - m).
    void (*predict_along_normal)(const Layout&, const FloatWeights& position, const FloatWeights& shape_weights,
                                 float sign, const float* v, const float* shape, const float* normals, float* d);
    /// Unit vertex normals; zero where they cancel.
    void (*normals)(const Layout&, const float* v, float* normals);
    /// x = (v - mean of ring)/4; with `normals` not null, its part along them.
    void (*shape)(const Layout&, const float* v, const float* normals, float* x);
    /// Details from local frames to model axes, or back.
    void (*turn)(const Layout&, bool to_model, const float* v, const float* normals, float* d);
    /// Vertices of the next level from those of this one and the points on its edges, and back.
    void (*interleave)(const Layout& coarse, const float* v, const float* d, const Layout& fine, float* fine_v);
    void (*deinterleave)(const Layout& fine, const float* fine_v, const Layout& coarse, float* v, float* d);
    /// A face's run of new interior points (semi_regular.h) to planes, and back.
    void (*load_details)(const Layout&, const Vec3f* run, float* d);
    void (*store_details)(const Layout&, const float* d, Vec3f* run);
    /// Loop's even rule at regular vertices: v = 2/5 v + 1/10 sum of d over the six edges; or its inverse.
    void (*loop_even)(const Layout&, bool inverse, const float* d, float* v);
};

/// For this machine.
const Kernels& kernels();

}  // namespace mvw
