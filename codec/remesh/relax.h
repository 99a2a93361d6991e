// Untangles and evens out a remesh: its vertices slide along the input surface until the triangles around each are as
// close to equilateral, and to their neighbours' size, as they can be together. What the collapses' local flattenings
// leave of distortion is paid for in every coefficient; what they leave of folds is seen.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/remesh/surface_walk.h"

namespace mvw {

struct RelaxOptions {
    unsigned sweeps = 30;  // at most; a vertex around which nothing moves any more is passed over
    unsigned threads = 1;
    std::span<const double> area_factors = {};  // (V), at the first sweep: of the areas around each point; empty: 1
};

/// points (V) on the surface, the vertices of `triangles`; those flagged `fixed` (V) stay. Each sweep takes the
/// vertices in turn (by the colours of a colouring: the result does not depend on the thread count) and lowers the sum
/// over a vertex' triangles of
///
///     (|a|^2 + |b|^2 + |b - a|^2) / chi(D)  +  s (chi(D)/A + A/chi(D))  +  t (a . (n - n_a))^2 / A,
///
/// a, b being the triangle's other corners seen from the vertex, n and n_a the surface's normals at it and at a, D the
/// doubled area, which falls below 0 as the triangle leans away from the mean normal of its three corners (that of one
/// corner alone would chase vertices from tips, where every triangle leans), A the doubled area aimed at, taken anew
/// every few sweeps (times `area_factors`, the first time), and chi a positive function that tends to the identity.
/// Where a corner is fixed its normal is left out: two surfaces may meet there. The first term is the MIPS energy
/// (Hormann, Greiner 2000), regularised so that it is finite at flipped triangles and turns them (Garanzha et al. 2021,
/// Foldover-free maps), the second keeps the density of the vertices (Degener et al. 2003), the third holds vertices on
/// ridges and tips. No step raises the sum. O(V) a sweep.
void relax(const SurfaceWalk& surface, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
           const RelaxOptions& options, std::vector<FacePoint>& points);

}  // namespace mvw
