#include "codec/mesh/io/affine.h"

namespace mvw {

Vec3 Affine::normal(const Vec3& n) const {
    const Vec3 m{dot(cross(row[1], row[2]), n), dot(cross(row[2], row[0]), n), dot(cross(row[0], row[1]), n)};
    return determinant() < 0 ? -m : m;
}

Affine Affine::after(const Affine& inner) const {
    Affine out;
    for (std::size_t r = 0; r < 3; ++r)
        out.row[r] = inner.row[0] * row[r].x + inner.row[1] * row[r].y + inner.row[2] * row[r].z;
    out.shift = (*this)(inner.shift);
    return out;
}

}  // namespace mvw
