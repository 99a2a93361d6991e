#include "codec/enc_lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace mvw {

namespace {

constexpr unsigned kMostStretch = 128;
constexpr unsigned kCoarse = 2, kCoarseShift = 4;  // looked at first, in steps; then beside the best
constexpr std::size_t kMostPlanes = 256;           // that count by themselves, those of most area
constexpr double kWorthItsBytes = 0.8;             // of the squared error
constexpr double kWorthNotNesting = 0.2;           // likewise, of all axes
constexpr double kSamePlane = 1e-9;

/// A plane across an axis, or a slice: where it is, and the area that looks along the axis.
struct Plane {
    double place = 0, area = 0;
};

/// What is across axis a, that of most area first; what lies anywhere comes last, with no place.
std::vector<Plane> planes_across(std::span<const Vec3> positions, const std::vector<Face>& faces, std::size_t a) {
    std::vector<double> area(positions.size(), 0);
    for (const Face& f : faces) {
        const Vec3 n = cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]);
        const double twice = length(n);
        if (twice <= 0) continue;
        for (const std::uint32_t v : f) area[v] += n[a] * n[a] / (6 * twice);
    }
    std::vector<Plane> planes;
    for (std::size_t v = 0; v < area.size(); ++v)
        if (area[v] > 0) planes.push_back({positions[v][a], area[v]});
    std::sort(planes.begin(), planes.end(), [](const Plane& p, const Plane& q) { return p.place < q.place; });
    std::size_t n = 0;
    for (const Plane& p : planes) {
        if (n > 0 && p.place - planes[n - 1].place < kSamePlane)
            planes[n - 1].area += p.area;
        else
            planes[n++] = p;
    }
    planes.resize(n);
    std::sort(planes.begin(), planes.end(),
              [](const Plane& p, const Plane& q) { return p.area != q.area ? p.area > q.area : p.place < q.place; });
    return planes;
}

/// One axis of a lattice: chosen by what rounding to it leaves, the squared distance times area.
class Axis {
 public:
    Axis(std::vector<Plane> planes, unsigned bits) : planes_(std::move(planes)), scale_(std::ldexp(1.0, int(bits))) {
        for (std::size_t k = kMostPlanes; k < planes_.size(); ++k) rest_ += planes_[k].area;
        planes_.resize(std::min(planes_.size(), kMostPlanes));
        plain_ = least_ = error(0, 0, INFINITY);
        nested_ = error(0, Lattice::kHalf, INFINITY);
        for (unsigned stretch = 0; stretch < kMostStretch; stretch += kCoarse)
            for (unsigned shift = 0; shift < 256; shift += kCoarseShift) offer(stretch, shift);
        const unsigned stretch = stretch_, shift = shift_;
        for (unsigned s = stretch > 0 ? stretch - 1 : 0; s <= stretch + 1; ++s)
            for (unsigned m = 0; m <= 2 * kCoarseShift; ++m) offer(s, (shift + 256 + m - kCoarseShift) % 256);
    }
    [[nodiscard]] std::uint8_t stretch() const { return static_cast<std::uint8_t>(stretch_); }
    [[nodiscard]] std::uint8_t shift() const { return static_cast<std::uint8_t>(shift_); }
    [[nodiscard]] double plain() const { return plain_; }
    [[nodiscard]] double nested() const { return nested_; }
    [[nodiscard]] double gain() const { return nested_ - least_; }
    [[nodiscard]] double least() const { return least_; }

 private:
    /// Looking stops above `most`.
    [[nodiscard]] double error(unsigned stretch, unsigned shift, double most) const {
        const double cell = 1 + stretch / 512.0, per_cell = scale_ / cell, moved = shift / 256.0;
        double sum = rest_ / 12;
        for (const Plane& p : planes_) {
            const double at = p.place * per_cell - moved, off = at - std::nearbyint(at);
            sum += p.area * off * off;
            if (sum * cell * cell > most) break;
        }
        return sum * cell * cell;
    }
    void offer(unsigned stretch, unsigned shift) {
        const double e = error(stretch, shift, least_);
        if (e < least_) least_ = e, stretch_ = stretch, shift_ = shift;
    }

    std::vector<Plane> planes_;
    double scale_, rest_ = 0, plain_ = 0, nested_ = 0, least_ = 0;
    unsigned stretch_ = 0, shift_ = 0;
};

}  // namespace

Lattice fit_lattice(std::span<const Vec3> positions, const std::vector<Face>& faces, unsigned bits) {
    const Lattice plain{static_cast<std::uint8_t>(bits), {}, {}};
    Lattice fitted = plain;
    double before = 0, after = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        const Axis axis(planes_across(positions, faces, a), bits);
        fitted.stretch[a] = axis.stretch();
        fitted.shift[a] = axis.shift();
        before += axis.plain();
        after += axis.least();
    }
    return after < kWorthItsBytes * before ? fitted : plain;
}

Lattice fit_nested_lattice(std::span<const Vec3> positions, const std::vector<Face>& faces, unsigned bits) {
    Lattice out = Lattice::nested(bits);
    std::vector<Axis> axes;
    double left = 0;
    for (std::size_t a = 0; a < 3; ++a) left += axes.emplace_back(planes_across(positions, faces, a), bits).nested();
    std::array<std::size_t, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return axes[a].gain() > axes[b].gain(); });
    for (const std::size_t a : order) {
        if (axes[a].gain() <= kWorthNotNesting * left) break;
        left -= axes[a].gain();
        out.stretch[a] = axes[a].stretch();
        out.shift[a] = axes[a].shift();
    }
    return out;
}

Rounded round_to(const Lattice& lattice, std::span<const Vec3> positions) {
    Rounded out{lattice, {}};
    out.grid.reserve(positions.size());
    for (const Vec3& p : positions) out.grid.push_back(lattice.nearest(p));
    return out;
}

std::vector<Vec3> points_of(const Rounded& rounded) {
    std::vector<Vec3> out;
    out.reserve(rounded.grid.size());
    for (const GridPoint& k : rounded.grid) out.push_back(rounded.lattice.point(k));
    return out;
}

double moved_by_rounding(const Rounded& rounded, std::span<const Vec3> positions, const std::vector<Face>& faces) {
    double area = 0, squares = 0;
    for (const Face& f : faces) {
        const Vec3 n = cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]);
        const double twice = length(n);
        if (twice <= 0) continue;
        std::array<double, 3> d{};
        for (std::size_t k = 0; k < 3; ++k)
            d[k] = dot(rounded.lattice.point(rounded.grid[f[k]]) - positions[f[k]], n) / twice;
        area += twice;
        // The mean square of what is linear over a triangle.
        squares += twice * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[0] * d[1] + d[1] * d[2] + d[2] * d[0]) / 6;
    }
    return area > 0 ? std::sqrt(squares / area) : 0;
}

Rounded round_to_lattice(std::span<const Vec3> positions, const std::vector<Face>& faces, unsigned bits) {
    return round_to(fit_lattice(positions, faces, bits), positions);
}

}  // namespace mvw
