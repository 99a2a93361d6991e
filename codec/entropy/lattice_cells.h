// Where a coordinate on one lattice may lie on a finer one.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "codec/mesh/lattice.h"

namespace mvw {

/// The cells of a lattice, along one axis, that share some of one cell of another.
class LatticeCells {
 public:
    LatticeCells(const Lattice& from, const Lattice& to, std::size_t a, std::int32_t place) {
        const double over = std::ldexp(from.cell(a) / to.cell(a), int{to.bits} - int{from.bits});
        const double at = (place + from.shift[a] / 256.0) * over - to.shift[a] / 256.0;
        low_ = at - over / 2, high_ = at + over / 2;
        constexpr double kTouch = 1e-6;  // of a cell: as good as nothing of it
        first_ = static_cast<std::int32_t>(std::ceil(low_ - 0.5 + kTouch));
        last_ = std::max(first_, static_cast<std::int32_t>(std::floor(high_ + 0.5 - kTouch)));
    }
    [[nodiscard]] std::int32_t first() const { return first_; }
    [[nodiscard]] std::int32_t last() const { return last_; }
    /// What of a cell lies in the other one, in cells.
    [[nodiscard]] double share(std::int32_t k) const {
        return std::max(std::min(high_, k + 0.5) - std::max(low_, k - 0.5), 0.0);
    }

 private:
    double low_, high_;  // of the other one, in cells
    std::int32_t first_, last_;
};

}  // namespace mvw
