// Backs of a surface are drawn further away than they are. Where a surface is folded over itself, as coarse levels are
// here and there, the front that a fold covers is then seen, and not a red speck; insides of open surfaces, which have
// nothing close behind them, are seen as ever.
#pragma once
#include <epoxy/gl.h>

#include <algorithm>

namespace mvw {

/// Where backs are drawn.
enum class Backs {
    InPlace,       // where they lie
    StepBehind,    // half a percent of the model's diagonal further away
    BehindFronts,  // further away than all fronts: for surfaces of solids
};

/// By what share of the window's depth backs lie further away. element14: of the projection's matrix; distance: from
/// the eye to the model's middle; diagonal: the model's. All in units of the eye's space.
inline double depth_shift(Backs backs, double element14, double distance, double diagonal) {
    constexpr double kMost = 0.5;  // fronts and backs have half of the window's depth each
    if (backs != Backs::StepBehind) return backs == Backs::InPlace ? 0 : kMost;
    const double step = 0.005 * diagonal;
    return std::min(kMost, -0.5 * element14 * step / (distance * (distance + step)));
}

/// Calls draw() for the backs and then for the fronts. What is drawn afterwards has the fronts' depths.
template <typename Draw>
void draw_sides(double shift, Draw draw) {
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    glDepthRange(shift, 1);
    draw();
    glCullFace(GL_BACK);
    glDepthRange(0, 1 - shift);
    draw();
    glDisable(GL_CULL_FACE);
}

}  // namespace mvw
