// The matrix-valued interpolatory Loop scheme as a surface generator (Jiang, Li, Zhu; the paper's section 3): every
// vertex carries a row [v, x], its position and a second component that shapes the surface around it.
#pragma once
#include <span>
#include <vector>

#include "codec/mesh/semi_regular.h"

namespace mvw {

struct SubdivideOptions {
    unsigned levels = 4;
    double shape = 1;        // x at first, times (v - mean of ring)/4: 0 none, 1 what keeps quadratics
    double s = 36.0 / 31.0;  // in (0, 36/31]: rule at vertices of valence other than 6
};

/// V(levels) positions in hierarchical order, from the base's.
///
///   even  [v', x'] = [v, x] G + sum of ring [v, x] L        odd  [e', x'] = ends J + opposites K + wings M + far N
///
/// The matrices are those of lifting.h (interpolatory_masks), at and around vertices of other valence
/// [v, x] H_n + mean of ring [v, x] H, and J_3, K_3. Positions interpolate: v' = v. On boundaries and creases, and at
/// the edges that touch them: midpoints, x = 0. creases: empty or a flag for each base edge. Smooth but at vertices of
/// other valence, where it is only continuous. O(V).
std::vector<Vec3> subdivide(const BaseMesh& base, std::span<const Vec3> positions, const SubdivideOptions& options,
                            std::span<const std::uint8_t> creases = {});

/// One step alone: positions and second components of the next level from this one's, V(j) + E(j) of each.
struct Level;
struct ShapedPoints {
    std::vector<Vec3> v, x;
};
ShapedPoints subdivide_once(const Level& level, const ShapedPoints& coarse, double s);

}  // namespace mvw
