#include "client/viewer/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mvw {
namespace {

constexpr double kMargin = 1.06;  // of the picture's side over the model's

double radians(double degrees) {
    return degrees * (std::numbers::pi / 180);
}

/// Along one axis of the picture: a point at (x, z), z towards the eye, is inside where
///   x - shift <= (distance - z) slope  and  shift - x <= (distance - z) slope.
struct Extent {
    double above = -std::numeric_limits<double>::infinity(), below = above;

    void add(double x, double z, double slope) {
        above = std::max(above, z + x / slope);
        below = std::max(below, z - x / slope);
    }
    [[nodiscard]] double distance() const { return (above + below) / 2; }
    [[nodiscard]] double shift(double slope) const { return (above - below) / 2 * slope; }
};

}  // namespace

Vec3 Camera::backward() const {
    const double y = radians(yaw), p = radians(pitch);
    return {std::sin(y) * std::cos(p), std::sin(p), std::cos(y) * std::cos(p)};
}
Vec3 Camera::right() const {
    return {std::cos(radians(yaw)), 0, -std::sin(radians(yaw))};
}
Vec3 Camera::up() const {
    return cross(backward(), right());
}

Camera fit_camera(const Mesh& mesh, double yaw, double pitch, double aspect) {
    Camera camera;
    camera.yaw = yaw;
    camera.pitch = pitch;
    const Vec3 right = camera.right(), up = camera.up(), backward = camera.backward();
    const Box box = bounding_box(mesh);
    const Vec3 center = box.empty() ? Vec3{} : box.center();
    const double size = box.diagonal() > 0 ? box.diagonal() : 1;
    const double slope_y = std::tan(radians(Camera::kFieldOfView / 2)) / kMargin, slope_x = slope_y * aspect;

    Extent across, upright;
    for (const Face& f : mesh.faces)
        for (const std::uint32_t v : f) {
            const Vec3 p = (mesh.positions[v] - center) / size;
            const double z = dot(p, backward);
            across.add(dot(p, right), z, slope_x);
            upright.add(dot(p, up), z, slope_y);
        }
    const bool has_extent = box.diagonal() > 0;
    const double distance = has_extent ? std::max(across.distance(), upright.distance()) : 1;
    const double dx = has_extent ? across.shift(slope_x) : 0, dy = has_extent ? upright.shift(slope_y) : 0;
    camera.distance = distance * size;
    camera.eye = center + (right * dx + up * dy + backward * distance) * size;
    return camera;
}

}  // namespace mvw
