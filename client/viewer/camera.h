// Where a picture is taken from.
#pragma once
#include "codec/mesh/mesh.h"

namespace mvw {

/// A perspective camera whose picture is `kFieldOfView` high. At yaw 0, pitch 0 it looks along -z with y up; yaw turns
/// it to the right around the model, pitch lifts it.
struct Camera {
    static constexpr double kFieldOfView = 24;  // degrees

    double yaw = 0, pitch = 0;  // degrees
    Vec3 eye;                   // model units
    double distance = 1;        // from the eye to the middle of what was fitted, model units; > 0

    [[nodiscard]] Vec3 right() const;
    [[nodiscard]] Vec3 up() const;
    [[nodiscard]] Vec3 backward() const;  // from the model to the eye
};

/// The nearest camera in that direction that has every vertex used by a face in its picture, with a small margin.
/// aspect: width / height of the picture. A mesh without extent, or without faces, is seen from distance 1.
Camera fit_camera(const Mesh& mesh, double yaw, double pitch, double aspect);

}  // namespace mvw
