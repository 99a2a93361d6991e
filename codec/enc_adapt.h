// Moves the vertices of a remesh along the surface to where they cost least to code.
//
// Where a vertex lies within the surface tells nothing about the shape, so bytes that say it are lost. slide() leads to
// a "normal mesh" (Guskov, Vidimce, Sweldens, Schroeder 2000) by iteration: details point along normals. snap() adds
// that the transform's coarse positions lie on normals of a base whose vertices are points of a coarse grid: only one
// number is left for each, its distance along the normal.
#pragma once
#include "codec/enc_input.h"
#include "codec/mesh/semi_regular.h"
#include "codec/part_units.h"
#include "codec/remesh/self_parameterization.h"
#include "codec/transform/transform.h"

namespace mvw {

/// A remesh together with where on the input its vertices belong.
class Adaptation {
 public:
    /// surface: must outlive this. mesh: a remesh of it, of at least one level, in its units.
    Adaptation(PartSurface& surface, const TransformOptions& transform, unsigned threads, SemiRegularMesh mesh);

    /// Rounds of: analysis, tangential details halved, synthesis, and a walk over the surface to where that leads
    /// (remesh/drift.h: as far as the triangles stand it), and to where coarse levels want their vertices
    /// (towards_fit()), level by level in turn. Then points go back to tips and pockets that lost them
    /// (remesh/cover.h), and the fit (remesh/settle.h), because vertices on the
    /// surface are not those that come nearest to it, and the colours of where they have come to rest. Vertices on
    /// boundaries, creases and borders between materials slide along these, but for those that hold a bend. Leaves all
    /// as it was where the result is farther from the surface than kMostLoss allows. O(V log F) a round.
    void slide(unsigned threads);

    struct Snapped {
        SemiRegularMesh mesh;
        Rounded base;
    };
    /// Rounds of: analysis, coarse positions to the nearest points of their normals, tangential details halved,
    /// synthesis; every vertex follows along the surface, as far above it as it was; then the fit. Vertices on
    /// boundaries, creases and borders between materials stay. O(V log F) a round.
    [[nodiscard]] Snapped snap(unsigned bits, unsigned threads) const;

    [[nodiscard]] const SemiRegularMesh& mesh() const { return mesh_; }

 private:
    [[nodiscard]] PatchTransform transform(unsigned threads) const;
    /// The positions (V) of `coefficients` with each detail's tangential components shortened.
    std::vector<Vec3> without_tangents(PatchTransform& transform, std::vector<Vec3f>& coefficients) const;
    /// Steps (V) that bring the surface of `level` < L, finer details left out, closer to the input: how coarse
    /// vertices lie along ridges and around tips is worth 1 to 2 dB of that, and once they lie well it costs nothing.
    /// The vertices of the level below lead, so that the level's own details stay normal; those of the base at level 0.
    /// Those on lines do not.
    std::vector<Vec3> towards_fit(PatchTransform& transform, const std::vector<Vec3f>& coefficients, unsigned level,
                                  unsigned threads) const;
    [[nodiscard]] double distance_of(const std::vector<Vec3>& positions, unsigned threads) const;

    PartSurface& surface_;
    SemiRegularMesh mesh_;
    const SurfaceWalk& walk_;
    const std::vector<Face> triangles_;
    const std::vector<std::uint8_t> fixed_;
    const TransformOptions options_;
    std::vector<FacePoint> points_;  // of the surface, nearest to the vertices
};

}  // namespace mvw
