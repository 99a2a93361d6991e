// Local frames of detail vectors: the normal of the level below at the edge that is split, and two tangents.
#pragma once
#include "codec/vec.h"

namespace mvw {

/// Orthonormal and right-handed: n, t along the edge within the tangent plane, b = n x t.
template <typename T>
struct Frame {
    Vector3<T> n, t, b;

    [[nodiscard]] Vector3<T> to_local(const Vector3<T>& d) const { return {dot(n, d), dot(t, d), dot(b, d)}; }
    [[nodiscard]] Vector3<T> to_model(const Vector3<T>& c) const { return n * c.x + t * c.y + b * c.z; }
};

/// normal_sum  sum of the unit vertex normals at the edge's two ends
/// edge        from the edge's first end to its second (Level: the direction of an edge)
/// Where the normals cancel or the edge stands on the tangent plane (sine below 1e-3) an axis stands in, so that the
/// frame is orthonormal for any input.
template <typename T>
Frame<T> make_frame(const Vector3<T>& normal_sum, const Vector3<T>& edge) {
    Frame<T> f;
    const T length_n = length(normal_sum);
    f.n = length_n > T(1e-3) ? normal_sum * (T(1) / length_n) : Vector3<T>{T(0), T(0), T(1)};
    const Vector3<T> flat = edge - f.n * dot(f.n, edge);
    const T length_t = length(flat);
    if (length_t > T(1e-3) * length(edge)) {
        f.t = flat * (T(1) / length_t);
    } else {
        const Vector3<T> axis = std::abs(f.n.x) < T(0.6) ? Vector3<T>{T(1), T(0), T(0)} : Vector3<T>{T(0), T(1), T(0)};
        const Vector3<T> stand_in = axis - f.n * dot(f.n, axis);
        f.t = stand_in * (T(1) / length(stand_in));
    }
    f.b = cross(f.n, f.t);
    return f;
}

}  // namespace mvw
