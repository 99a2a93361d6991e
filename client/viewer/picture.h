// Pictures of meshes without a window (EGL, surfaceless): what `mvw view --screenshot` and every report draws with.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "client/viewer/camera.h"
#include "client/viewer/image.h"
#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

struct PictureOptions {
    unsigned width = 1024, height = 768;  // 1 to kMaxPictureSide each
    bool wireframe = false;
    bool flat = false;                     // facet normals instead of smooth ones
    bool backs_in_place = false;           // what lies nearest is drawn, be it a back (sides.h): to find folds
    double yaw = 30, pitch = 15;           // degrees around the model; it always fills the picture
    std::optional<Camera> camera;          // instead of yaw and pitch: several pictures from one place
    std::vector<std::vector<Vec3>> lines;  // polylines drawn over the surface where it does not hide them
};

inline constexpr unsigned kMaxPictureSide = 4096;

/// Draws one mesh with a headless OpenGL context, in its per-vertex colours where it has them. Back faces are tinted
/// red; fronts close behind them are drawn instead, and of solids seen from outside no back is (sides.h). Smooth
/// shading leaves edges of over 40 degrees sharp. The same mesh and options give the same picture. InvalidArgument for
/// a side out of range or a vertex that is not finite; Io where no OpenGL can be had (the message names the package).
Result<Image> draw_picture(const Mesh& mesh, const PictureOptions& options);

/// Colours for `values` from blue (0) over green to red (`top` and above): error pictures.
std::vector<Rgba8> heat_colors(const std::vector<double>& values, double top);

/// The lines of `lines` above for a base mesh's edges: side s of base face f at a level's grid, see semi_regular.h.
/// positions: V(level) points in hierarchical order.
class BaseMesh;
std::vector<std::vector<Vec3>> base_edge_lines(const BaseMesh& base, unsigned level,
                                               const std::vector<Vec3>& positions);

}  // namespace mvw
