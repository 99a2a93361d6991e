// Small meshes of known topology, and ways to spoil them; smooth shapes are in shapes.h.
#pragma once
#include "codec/mesh/mesh.h"

namespace mvw {

Mesh tetrahedron_mesh();
/// Open square in the plane z = 0 of n x n quads cut in two.
Mesh grid_mesh(unsigned n);
/// Moebius strip of n quads around, cut in two: cannot be oriented.
Mesh moebius_mesh(unsigned n);
/// The two side by side, without sharing anything; both with or both without attributes.
Mesh join(Mesh a, const Mesh& b);
/// Every corner gets a vertex of its own, as in an STL.
Mesh without_sharing(const Mesh& mesh);

}  // namespace mvw
