// Evens out where the grid's points lie on the input surface, and fits their positions to it.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/remesh/self_parameterization.h"

namespace mvw {

/// Which faces meet at each side of a mesh's faces, and a face at each vertex: enough to walk over it.
class SurfaceWalk {
public:
    explicit SurfaceWalk(const Mesh& mesh);
    /// The nearest point to `target` that a descent from `start` reaches over neighbouring faces: near `start` it is the
    /// closest point, but it never jumps to another sheet of the surface.
    [[nodiscard]] FacePoint closest_from(const FacePoint& start, const Vec3& target) const;
    [[nodiscard]] Vec3 position(const FacePoint& p) const;
    [[nodiscard]] Vec3 normal(std::uint32_t face) const;

private:
    const Mesh& mesh_;
    std::vector<std::uint32_t> vertex_face_begin_, vertex_faces_;
};

/// Moves every point of a triangulated grid towards the middle of its neighbours, along the surface; points flagged
/// `fixed` stay. A move that turns a triangle against the surface is taken back.
void relax(const SurfaceWalk& surface, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
           unsigned rounds, std::vector<FacePoint>& points, unsigned threads);

}  // namespace mvw
