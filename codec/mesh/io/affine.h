// Affine maps: where files place their meshes.
#pragma once
#include <array>

#include "codec/vec.h"

namespace mvw {

/// Rows of an affine map: linear part and translation.
struct Affine {
    std::array<Vec3, 3> row{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    Vec3 shift;

    [[nodiscard]] Vec3 linear(const Vec3& p) const { return {dot(row[0], p), dot(row[1], p), dot(row[2], p)}; }
    [[nodiscard]] Vec3 operator()(const Vec3& p) const { return linear(p) + shift; }
    [[nodiscard]] double determinant() const { return dot(row[0], cross(row[1], row[2])); }
    /// Along the normal of a surface that is mapped, where `n` is along it before.
    [[nodiscard]] Vec3 normal(const Vec3& n) const;
    /// First `inner`, then this.
    [[nodiscard]] Affine after(const Affine& inner) const;
};

}  // namespace mvw
