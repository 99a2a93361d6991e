// Lets the vertices of a remesh go where something else wants them, as far as the triangles stand it.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/measure/surface_error.h"
#include "codec/remesh/rings.h"
#include "codec/remesh/self_parameterization.h"
#include "codec/remesh/surface_walk.h"

namespace mvw {

/// The vertices of a remesh on a surface, each joined to its neighbours.
class Drift {
 public:
    /// points (V): on the surface, the vertices of `triangles`. Those flagged `fixed` (V) do not move. No triangle's
    /// sides grow beyond kMostGrowth times the longest that it has now, so that tips and ridges are not left bare.
    Drift(const SurfaceWalk& surface, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
          std::vector<FacePoint> points, unsigned threads);

    /// Walks each vertex along its step (V, model units), or half of it, or a quarter, the most that leaves every
    /// triangle around it upright, well shaped or at least no worse than it was. Any thread count gives the same. O(V).
    void move(const std::vector<Vec3>& steps);

    /// Puts a vertex somewhere else, `fixed` or not. False, and nothing is done, where the triangles do not stand that.
    bool put(std::uint32_t v, const FacePoint& where);

    [[nodiscard]] const std::vector<FacePoint>& points() const { return points_; }
    [[nodiscard]] const Vec3& position(std::uint32_t v) const { return places_[v].position; }
    /// Of the surface, at each vertex (V).
    [[nodiscard]] std::vector<Vec3> normals() const;
    /// At one; zero for a fixed one, where two surfaces may meet.
    [[nodiscard]] const Vec3& normal(std::uint32_t v) const { return places_[v].normal; }

 private:
    struct Place {
        Vec3 position, normal;
    };
    [[nodiscard]] Place place_of(std::uint32_t v, const FacePoint& p) const;
    [[nodiscard]] bool stands(std::uint32_t v, const Place& there) const;

    const SurfaceWalk& surface_;
    const Rings rings_;
    const unsigned threads_;
    const std::vector<std::uint8_t>& fixed_;
    const std::vector<std::vector<std::uint32_t>> groups_;
    std::vector<FacePoint> points_;
    std::vector<Place> places_;
    std::vector<double> most_;  // of each triangle's sides, squared
};

/// The points of an indexed surface that are nearest to `positions`.
std::vector<FacePoint> closest_points(const ReferenceSurface& surface, const std::vector<Vec3>& positions,
                                      unsigned threads);

}  // namespace mvw
