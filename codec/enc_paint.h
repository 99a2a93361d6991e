// Colours of a part's vertices, taken from materials and images where the vertices that are coded lie.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "codec/measure/surface_index.h"
#include "codec/mesh/paintwork.h"
#include "codec/mesh/semi_regular.h"
#include "codec/transform/transform.h"

namespace mvw {

/// Any number of threads may use it at once.
class Painter {
 public:
    /// paintwork: at least one face; must outlive this. center, diagonal: where positions of parts, in units of the
    /// latter, lie in those of the paintwork. threads: to build an index of its faces, at least 1.
    Painter(const Paintwork& paintwork, const Vec3& center, double diagonal, unsigned threads);

    /// The same surface with colours, and with as many levels more, their details zero, as it takes to show what the
    /// paintwork has between vertices (kShown), but not more vertices than `most`. A vertex has the mean of its place
    /// and the middles of its edges, so that a pattern too fine comes out as its mean. Fields follow. part: of at least
    /// one level.
    [[nodiscard]] SemiRegularMesh paint(SemiRegularMesh part, const TransformOptions& transform, double most,
                                        unsigned threads) const;

 private:
    [[nodiscard]] std::vector<std::array<double, 4>> sample(std::span<const Vec3> positions, unsigned threads) const;

    const Paintwork& paintwork_;
    const Vec3 center_;
    const double diagonal_;
    const SurfaceIndex index_;
};

}  // namespace mvw
