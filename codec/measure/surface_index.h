// Closest points on a triangle mesh: exact in double precision, found through an Embree bounding-volume hierarchy.
// The hierarchy works in floats; it only proposes triangles, from a radius widened by what floats may have rounded, so
// the answer is that of a search over all triangles, however far from the origin or however large the mesh is.
// Point and triangle: Ericson, Real-Time Collision Detection (2005), 5.1.5.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"

namespace mvw {

/// A point on a mesh.
struct SurfacePoint {
    std::uint32_t face = kNone;
    std::array<double, 3> barycentric{};  // over the face's corners; not negative, sum 1
    Vec3 point;                           // model units
    double distance = 0;                  // from the point asked for, model units
};

/// The point of triangle a b c nearest to p, as barycentric weights. Right for triangles without area, too.
std::array<double, 3> closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Built once over a mesh (which it copies what it needs of), asked many times, from any number of threads at once.
class SurfaceIndex {
 public:
    /// positions  V points, finite
    /// faces      F >= 1 triangles (assert), indices below V
    /// threads    used for building; 0: all cores
    /// O(F log F) time; about 180 bytes a face.
    SurfaceIndex(std::span<const Vec3> positions, std::span<const Face> faces, unsigned threads = 0);
    ~SurfaceIndex();
    SurfaceIndex(SurfaceIndex&&) noexcept;
    SurfaceIndex& operator=(SurfaceIndex&&) noexcept;

    /// The nearest point of the mesh; among equally near faces that of the lowest number, so that the answer does not
    /// depend on the hierarchy. near_face: a face thought to be close (the last answer for a neighbour), which makes
    /// the search several times faster and never changes its result.
    [[nodiscard]] SurfacePoint closest(const Vec3& p, std::uint32_t near_face = kNone) const;

 private:
    struct Hierarchy;
    std::unique_ptr<Hierarchy> hierarchy_;
};

}  // namespace mvw
