// The passes that sides.h speaks of. Edges that are drawn as lines lie where they are, those of a fold's back, too.
#pragma once
#include <epoxy/gl.h>

#include "client/viewer/sides.h"

namespace mvw {

/// Calls draw(), which draws the triangles of one surface, once for each side that is seen. further: the uniform of the
/// program in use by which it draws vertices further away than they are (shaders.h); step: for backs, kBackStep of the
/// model's diagonal, in units of the eye's space.
template <typename Draw>
void draw_sides(Backs backs, GLint further, double step, Draw draw) {
    glUniform1f(further, 0);
    if (backs == Backs::InPlace) return draw();
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    draw();
    if (backs == Backs::StepBehind) {
        glCullFace(GL_FRONT);
        glUniform1f(further, static_cast<float>(step));
        draw();
    }
    glDisable(GL_CULL_FACE);
}

}  // namespace mvw
