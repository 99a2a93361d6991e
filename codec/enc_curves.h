// Boundaries, creases and borders of a remesh as curves, and vertices that slide along them.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/measure/surface_error.h"
#include "codec/mesh/semi_regular.h"
#include "codec/remesh/drift.h"

namespace mvw {

/// One such line between two base vertices: its finest vertices, and where they were at first.
class LineCurve {
 public:
    /// vertices: in order along the curve; positions (V) of all vertices.
    LineCurve(std::vector<std::uint32_t> vertices, const std::vector<Vec3>& positions);

    /// Each inner vertex in turn to the point of the curve nearest to wanted[v], between its neighbours, as far as its
    /// triangles stand it; those that hold a bend stay. reference: of the surface that `drift` is on.
    void slide(const ReferenceSurface& reference, const std::vector<Vec3>& wanted, Drift& drift,
               std::vector<Vec3>& positions);

 private:
    [[nodiscard]] bool is_bend(std::size_t t) const;
    [[nodiscard]] double nearest(const Vec3& p) const;
    [[nodiscard]] Vec3 at(double place) const;

    std::vector<std::uint32_t> vertices_;
    std::vector<Vec3> points_;
    std::vector<std::uint8_t> stays_;
    std::vector<double> places_;  // where on the curve the vertices are now: a point's number and a fraction
};

/// The curves of all base edges whose inner vertices are flagged in `on_line` (V).
std::vector<LineCurve> curves_of(const SemiRegularMesh& mesh, const std::vector<std::uint8_t>& on_line);

}  // namespace mvw
