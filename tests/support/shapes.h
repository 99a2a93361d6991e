// Meshes of known shape for tests.
#pragma once
#include "codec/mesh/mesh.h"

namespace mvw {

/// A mesh without attributes.
Mesh mesh_of(std::vector<Vec3> positions, std::vector<Face> faces);

/// Two triangles over [0,1] x [0,1] at z = 0, facing +z.
Mesh unit_square();
/// Closed, 8 vertices, 12 triangles over [0,1]^3; the last two form the side x = 1.
Mesh unit_cube();
/// Unit sphere: an icosahedron split 4 to 1 `levels` times (20 * 4^levels faces, 10 * 4^levels + 2 vertices).
Mesh icosphere(unsigned levels);
/// Torus about z: radius 1, tube 0.4; 2 * around * along faces, 3 or more of each.
Mesh torus(std::uint32_t around, std::uint32_t along);
/// The same with noise in each coordinate, up to `noise`: no subdivision connectivity where both are odd, nothing
/// smooth.
Mesh rough_torus(std::uint32_t around, std::uint32_t along, double noise);

/// Closed plate of 1 by 1 by 0.2 with a chequer of `rings` by `rings` raised fields, walls between them, finely meshed:
/// flat parts and sharp edges alone.
Mesh chequered_plate(unsigned rings);

Mesh moved(Mesh mesh, const Vec3& by);
Mesh scaled(Mesh mesh, double factor);

}  // namespace mvw
