// Error quadrics of edge-collapse simplification (Garland & Heckbert 1997, Surface Simplification Using Quadric Error
// Metrics), weighted by area.
#pragma once
#include <array>
#include <cmath>

#include "codec/vec.h"

namespace mvw {

/// x -> x^T A x - 2 b^T x + c, the weighted sum of squared distances to planes.
struct Quadric {
    std::array<double, 6> a{};  // xx xy xz yy yz zz
    Vec3 b;
    double c = 0;

    /// Adds weight * (n . (x - p))^2, n a unit vector.
    void add_plane(const Vec3& n, const Vec3& p, double weight) {
        const double d = dot(n, p);
        a[0] += weight * n.x * n.x, a[1] += weight * n.x * n.y, a[2] += weight * n.x * n.z;
        a[3] += weight * n.y * n.y, a[4] += weight * n.y * n.z, a[5] += weight * n.z * n.z;
        b += n * (weight * d);
        c += weight * d * d;
    }
    /// Adds weight * |x - p|^2.
    void add_point(const Vec3& p, double weight) {
        a[0] += weight, a[3] += weight, a[5] += weight;
        b += p * weight;
        c += weight * squared_length(p);
    }
    Quadric& operator+=(const Quadric& o) {
        for (std::size_t k = 0; k < 6; ++k) a[k] += o.a[k];
        b += o.b;
        c += o.c;
        return *this;
    }
    [[nodiscard]] double trace() const { return a[0] + a[3] + a[5]; }
    [[nodiscard]] double operator()(const Vec3& x) const {
        const double xx = a[0] * x.x * x.x + a[3] * x.y * x.y + a[5] * x.z * x.z;
        const double xy = a[1] * x.x * x.y + a[2] * x.x * x.z + a[4] * x.y * x.z;
        return xx + 2 * xy - 2 * dot(b, x) + c;
    }
    /// The x of least value, A symmetric and positive definite (callers add_point() to make it so); `fallback` where
    /// A is singular to rounding.
    [[nodiscard]] Vec3 minimum(const Vec3& fallback) const {
        const double c00 = a[3] * a[5] - a[4] * a[4], c01 = a[2] * a[4] - a[1] * a[5], c02 = a[1] * a[4] - a[2] * a[3];
        const double det = a[0] * c00 + a[1] * c01 + a[2] * c02;
        const double scale = trace();
        if (!(det > 1e-14 * scale * scale * scale)) return fallback;
        const double c11 = a[0] * a[5] - a[2] * a[2], c12 = a[1] * a[2] - a[0] * a[4], c22 = a[0] * a[3] - a[1] * a[1];
        return Vec3{c00 * b.x + c01 * b.y + c02 * b.z, c01 * b.x + c11 * b.y + c12 * b.z,
                    c02 * b.x + c12 * b.y + c22 * b.z} /
               det;
    }
};

}  // namespace mvw
