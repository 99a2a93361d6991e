// Three-component vectors: double for geometry that must be right, float for bulk storage.
#pragma once
#include <cmath>
#include <cstddef>

namespace mvw {

/// A point or vector of three numbers of type T. Plain data: T[3] in memory, no padding.
template <typename T>
struct Vector3 {
    T x{}, y{}, z{};

    constexpr T& operator[](std::size_t i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr const T& operator[](std::size_t i) const { return i == 0 ? x : i == 1 ? y : z; }
    constexpr Vector3& operator+=(const Vector3& o) { return x += o.x, y += o.y, z += o.z, *this; }
    constexpr Vector3& operator-=(const Vector3& o) { return x -= o.x, y -= o.y, z -= o.z, *this; }
    constexpr Vector3& operator*=(T k) { return x *= k, y *= k, z *= k, *this; }
    friend constexpr Vector3 operator+(Vector3 a, const Vector3& b) { return a += b; }
    friend constexpr Vector3 operator-(Vector3 a, const Vector3& b) { return a -= b; }
    friend constexpr Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
    friend constexpr Vector3 operator*(Vector3 a, T k) { return a *= k; }
    friend constexpr Vector3 operator*(T k, Vector3 a) { return a *= k; }
    friend constexpr Vector3 operator/(Vector3 a, T k) { return a *= T(1) / k; }
    friend constexpr bool operator==(const Vector3&, const Vector3&) = default;
};

using Vec3 = Vector3<double>;
using Vec3f = Vector3<float>;

template <typename T>
constexpr T dot(const Vector3<T>& a, const Vector3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename T>
constexpr Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <typename T>
constexpr T squared_length(const Vector3<T>& a) {
    return dot(a, a);
}
template <typename T>
T length(const Vector3<T>& a) {
    return std::sqrt(dot(a, a));
}
/// Unit vector along a; zero where a is zero.
template <typename T>
Vector3<T> normalized(const Vector3<T>& a) {
    const T l = length(a);
    return l > T(0) ? a / l : Vector3<T>{};
}
constexpr Vec3 to_double(const Vec3f& a) {
    return {a.x, a.y, a.z};
}
constexpr Vec3f to_float(const Vec3& a) {
    return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

}  // namespace mvw
