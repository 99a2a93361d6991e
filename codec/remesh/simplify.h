// Coarser versions of a mesh by edge collapses that quadrics rate (Garland & Heckbert 1997), vertices where these are
// least: for how a model looks in a few bytes. No parameterisation is kept (self_parameterization.h).
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/remesh/collapse_mesh.h"
#include "codec/remesh/quadric.h"

namespace mvw {

/// What a collapse has done, for who undoes it. Vertices have the input's numbers.
struct Collapse {
    std::uint32_t kept = 0, removed = 0;
    std::array<Vec3, 2> before;                // where these two were, ...
    Vec3 after;                                // ... and where the one is that is left
    std::uint32_t from = 0, to = 0;            // the same two, along a half-edge that had a face
    std::uint32_t left = 0;                    // third vertex of that face, and
    std::uint32_t right = 0;                   // of the one on the edge's other side; kNone on a boundary
    std::array<bool, 2> on_boundary{};         // `from`, `to`
    std::array<std::uint32_t, 2> materials{};  // of the two faces
};

/// Collapses edges, the cheapest first, as far as it is told to.
class Simplifier {
 public:
    /// mesh: clean, of about unit size near the origin (quadrics hold squares of coordinates); outlives this. Borders
    /// between materials are kept like boundaries.
    /// stay: an end of an edge is as good as the best place where it costs no more than so many times that.
    explicit Simplifier(const Mesh& mesh, double stay = 1);
    ~Simplifier();

    /// Until no more faces are left, or nothing can be collapsed without turning a face over or changing the topology.
    void simplify(std::size_t faces);
    /// One round of collapses, `most` at most, which vertex splits can undo in any order: none leads to a vertex beside
    /// one that another has led to, and each removed face has a neighbour of its material. Vertices of more than
    /// `most_valence` faces are not made. Empty where nothing can be collapsed any more.
    std::vector<Collapse> simplify_round(std::size_t most, std::size_t most_valence);
    [[nodiscard]] std::size_t faces() const { return mesh_.live_faces(); }
    /// Positions, faces and materials of what is left. numbers: null, or gets the input's number of each vertex.
    [[nodiscard]] Mesh mesh(std::vector<std::uint32_t>* numbers = nullptr) const;

 private:
    struct Candidate;
    void init_quadrics();
    [[nodiscard]] bool rate(std::uint32_t h, Candidate& out) const;
    [[nodiscard]] bool keeps_sides(const Vec3& position) const;
    void push_around(std::uint32_t v);
    [[nodiscard]] bool is_current(const Candidate& c) const;
    /// Fills ring_; false where it must not be collapsed.
    [[nodiscard]] bool may_collapse(const Candidate& c);
    void collapse(const Candidate& c);
    [[nodiscard]] bool has_material_beside(std::uint32_t h) const;

    const Mesh& input_;
    const double stay_;
    CollapseMesh mesh_;
    std::vector<Quadric> quadrics_;
    std::vector<std::uint32_t> version_;  // of each vertex: rises when it is an end of an edge that collapses
    std::vector<Candidate> queue_;        // a heap
    EdgeRing ring_;
};

}  // namespace mvw
