// Relaxation that sees to it that a remesh covers its input: points go to where their triangles miss the surface.
// Collapses squeeze tips and pockets into small parts of a base face, and relax() keeps the density that it finds, so
// that nothing else would bring points there.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/remesh/self_parameterization.h"
#include "codec/remesh/surface_walk.h"

namespace mvw {

/// relax() in a few rounds. Between two of them each vertex of `mesh`, but for those on boundaries and features, is
/// given to the point that is nearest along edges; how far it is from the triangles there is what that point misses.
/// Areas aimed at follow from that: less where more is missed, and the other way around. From the second time on the
/// places that are missed most, and by a good part of the triangles' size, take their nearest point, which then stays.
///
/// mesh      what `surface` was made of; components may be without points
/// points    (V) on it, the vertices of `triangles`; out: where they are now
/// fixed     (V) flags of points that stay
///
/// Deterministic whatever the thread count. O(V + M log M) a round, M the vertices of `mesh`.
void relax_to_cover(const Mesh& mesh, const SurfaceWalk& surface, const std::vector<Face>& triangles,
                    const std::vector<std::uint8_t>& fixed, unsigned threads, std::vector<FacePoint>& points);

/// Draws points to what is missed most, as above, and lets those around them make room; all others stay. mesh, surface,
/// triangles, fixed, threads, points: as above. Returns whether any moved.
bool cover_missed(const Mesh& mesh, const SurfaceWalk& surface, const std::vector<Face>& triangles,
                  const std::vector<std::uint8_t>& fixed, unsigned threads, std::vector<FacePoint>& points);

}  // namespace mvw
