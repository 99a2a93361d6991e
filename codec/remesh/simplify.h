// Coarser versions of a mesh by edge collapses that quadrics rate (Garland & Heckbert 1997), vertices where these are
// least: for how a model looks in a few bytes. No parameterisation is kept (self_parameterization.h).
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/remesh/collapse_mesh.h"
#include "codec/remesh/quadric.h"

namespace mvw {

/// Collapses edges, the cheapest first, as far as it is told to.
class Simplifier {
 public:
    /// mesh: clean, of about unit size near the origin (quadrics hold squares of coordinates); outlives this. Borders
    /// between materials are kept like boundaries.
    explicit Simplifier(const Mesh& mesh);
    ~Simplifier();

    /// Until no more faces are left, or nothing can be collapsed without turning a face over or changing the topology.
    void simplify(std::size_t faces);
    [[nodiscard]] std::size_t faces() const { return mesh_.live_faces(); }
    /// Positions, faces and materials of what is left.
    [[nodiscard]] Mesh mesh() const;

 private:
    struct Candidate;
    void init_quadrics();
    [[nodiscard]] bool rate(std::uint32_t h, Candidate& out) const;
    [[nodiscard]] bool keeps_sides(const Vec3& position) const;
    void push_around(std::uint32_t v);

    const Mesh& input_;
    CollapseMesh mesh_;
    std::vector<Quadric> quadrics_;
    std::vector<std::uint32_t> version_;  // of each vertex: rises when it is an end of an edge that collapses
    std::vector<Candidate> queue_;        // a heap
    EdgeRing ring_;
};

}  // namespace mvw
