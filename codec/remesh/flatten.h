// One planar domain for the surroundings of an edge before and after its collapse: the step of successive
// self-parameterisation (Liu, Kim, Chaudhuri, Aigerman, Jacobson 2020, Neural Subdivision, section 4; Liu et al. 2021,
// Surface Multigrid via Intrinsic Prolongation).
#pragma once
#include <cstdint>
#include <vector>

#include "codec/remesh/collapse_mesh.h"

namespace mvw {

/// A point of a local chart. Single precision on purpose: what is checked for flips is what is stored.
struct Uv {
    float u = 0, v = 0;
};

/// Twice the signed area of (a, b, c), positive counter-clockwise, exact enough for float input.
inline double doubled_area(const Uv& a, const Uv& b, const Uv& c) {
    return (double{b.u} - a.u) * (double{c.v} - a.v) - (double{c.u} - a.u) * (double{b.v} - a.v);
}

/// What the collapse does to the ends of its edge.
enum class CollapseMode : std::uint8_t {
    Free,      // both ends move inside the surface
    KeepEnd,   // the kept end is on a line or a corner and stays where it is, the other one is free
    Slide,     // a feature or boundary edge: both ends move along that line
    SlideEnd,  // the same, with the kept end a corner that stays
};

struct FlattenLimits {
    double max_stretch = 6;  // ratio of the singular values of surface -> plane, triangles after the collapse
};

/// Flattens ring vertices, the two ends and the new vertex. uv: out, ring vertices, then kept end, removed end, new
/// vertex. False where some triangle before or after would flip, fold over or stretch too far. Lines stay straight
/// where the collapse slides along them, so that both sides of a line and the outside of a boundary agree.
bool flatten(const CollapseMesh& mesh, const EdgeRing& ring, const Vec3& position, CollapseMode mode,
             const FlattenLimits& limits, std::vector<Uv>& uv);

}  // namespace mvw
