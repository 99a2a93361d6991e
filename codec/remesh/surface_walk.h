// Points that move along a triangle mesh: a step in space becomes a straight path over the faces.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/remesh/self_parameterization.h"

namespace mvw {

/// A mesh prepared for walking. Keeps references to what it was made of.
class SurfaceWalk {
 public:
    /// mesh: clean. sharp: empty, or a flag a half-edge (3 * face + side); normals are not averaged over these.
    SurfaceWalk(const Mesh& mesh, std::span<const std::uint8_t> sharp);

    /// Where a path from `start` ends that sets out along `step` (model units; its part along the face's normal is left
    /// out), goes straight on over edges as if the faces were unfolded into a plane, and stops at boundaries, at sharp
    /// edges, and at faces without area.
    [[nodiscard]] FacePoint walk(const FacePoint& start, const Vec3& step) const;

    /// Whether paths stop at a half-edge (3 * face + side).
    [[nodiscard]] bool stops_at(std::uint32_t half_edge) const { return mates_[half_edge] == kNone; }

    [[nodiscard]] Vec3 position(const FacePoint& p) const;
    /// Unit normal, interpolated between the corners' averages; zero where those cancel.
    [[nodiscard]] Vec3 normal(const FacePoint& p) const;

 private:
    const Mesh& mesh_;
    std::vector<std::uint32_t> mates_;   // of each half-edge, kNone where a path stops
    std::vector<std::uint32_t> corner_;  // of each corner, index into normals_
    std::vector<Vec3> normals_;
};

}  // namespace mvw
