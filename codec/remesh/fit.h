// Least-squares fit of a remesh to the input surface: sampled vertices lie on the surface, so that all flat triangles
// between them lie to one side of it; moving the vertices a little off the surface halves the error.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

struct FitOptions {
    unsigned rounds = 1;       // of finding closest points and solving
    double samples = 6;        // points on the input for each vertex that is fitted
    double tangential = 0.05;  // weight of the distance along the surface against that from it
    double damping = 0.2;      // pull of a vertex to where it was, against a sample's weight
    unsigned threads = 1;
};

/// Moves `positions` (V) so that the surface `triangles` comes closer to `input`; vertices flagged `fixed` (V) stay. A
/// move that turns a triangle over is taken back. Deterministic whatever the thread count.
void fit(const Mesh& input, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
         const FitOptions& options, std::vector<Vec3>& positions);

/// Where the vertices of a coarse level want to go so that a finer surface, were it to follow them linearly over their
/// triangles, comes closer to `input`: displacements (V(coarse)). positions (V(level)): of the finer surface, level >=
/// coarse. Vertices flagged `fixed` (V(coarse)) stay. One round whatever the options say, with 30,000 samples at least;
/// what would turn triangles over is not taken back. Deterministic whatever the thread count.
std::vector<Vec3> fit_coarse(const Mesh& input, const BaseMesh& base, unsigned level,
                             const std::vector<Vec3>& positions, unsigned coarse,
                             const std::vector<std::uint8_t>& fixed, const FitOptions& options);

}  // namespace mvw
