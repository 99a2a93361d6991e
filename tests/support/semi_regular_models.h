// Semi-regular meshes for tests of what lies behind the remesher.
#pragma once
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// Takes up to `levels` levels off a mesh stored level by level in which the children of face k are faces 4k to 4k + 3
/// of the next level, 4k the one in the middle (the sr_*.ply models).
SemiRegularMesh from_level_order(const Mesh& mesh, unsigned levels);

/// A base refined `levels` times by midpoints, each new point moved by `place`.
template <typename Place>
SemiRegularMesh refine(const BaseMesh& base, const std::vector<Vec3>& points, unsigned levels, Place place) {
    SemiRegularMesh out{base, levels, std::vector<Vec3>(vertices_at_level(base, levels)), {}, {}, {}};
    std::vector<std::uint32_t> patch;
    const double n = double(1u << levels);
    for (std::uint32_t f = 0; f < base.face_count(); ++f) {
        patch_vertices(base, f, levels, patch);
        const Face& c = base.faces()[f];
        std::size_t at = 0;
        for (double i = 0; i <= n; ++i)
            for (double k = 0; i + k <= n; ++k)
                out.positions[patch[at++]] =
                    place(points[c[0]] * ((n - i - k) / n) + points[c[1]] * (i / n) + points[c[2]] * (k / n));
    }
    return out;
}

/// A bumpy ball over an octahedron.
SemiRegularMesh bumpy_ball(unsigned levels);

/// All of it as a plain mesh at its finest level.
Mesh plain(const SemiRegularMesh& mesh);

}  // namespace mvw
