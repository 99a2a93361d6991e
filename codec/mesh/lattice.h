// The grid that the vertices of a base lie on.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "codec/vec.h"

namespace mvw {

using GridPoint = std::array<std::int32_t, 3>;

/// Cells of 2^-bits along each axis, or up to half as much longer and moved, so that planes of a model come to lie on
/// it: coordinate a of a point k is (k + shift_a / 256) * (1 + stretch_a / 512) * 2^-bits.
struct Lattice {
    static constexpr std::uint8_t kHalf = 128;  // of a cell, as a shift

    std::uint8_t bits = 10;
    std::array<std::uint8_t, 3> stretch{}, shift{};

    friend bool operator==(const Lattice&, const Lattice&) = default;
    [[nodiscard]] bool is_plain() const {
        return stretch == std::array<std::uint8_t, 3>{} && shift == std::array<std::uint8_t, 3>{};
    }
    /// Each of its cells is two along each axis of the nested one of one bit more.
    static Lattice nested(unsigned bits) { return {static_cast<std::uint8_t>(bits), {}, {kHalf, kHalf, kHalf}}; }
    [[nodiscard]] bool is_nested() const { return *this == nested(bits); }
    [[nodiscard]] double unit() const { return std::ldexp(1.0, -int{bits}); }
    /// Along an axis, in units.
    [[nodiscard]] double cell(std::size_t a) const { return 1 + stretch[a] / 512.0; }
    /// In units.
    [[nodiscard]] Vec3 in_units(const GridPoint& k) const {
        Vec3 p;
        for (std::size_t a = 0; a < 3; ++a) p[a] = (k[a] + shift[a] / 256.0) * cell(a);
        return p;
    }
    [[nodiscard]] Vec3 point(const GridPoint& k) const { return in_units(k) * unit(); }
    [[nodiscard]] GridPoint nearest(const Vec3& p) const {
        GridPoint k{};
        for (std::size_t a = 0; a < 3; ++a)
            k[a] = static_cast<std::int32_t>(std::lround(std::ldexp(p[a], int{bits}) / cell(a) - shift[a] / 256.0));
        return k;
    }
};

/// Vertices on a lattice.
struct Rounded {
    Lattice lattice;
    std::vector<GridPoint> grid;
};

}  // namespace mvw
