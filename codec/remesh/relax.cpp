#include "codec/remesh/relax.h"

#include <algorithm>
#include <cmath>

#include "codec/remesh/parallel.h"
#include "codec/remesh/rings.h"

namespace mvw {

namespace {

constexpr double kSizeWeight = 10;    // of the area term against the shape term
constexpr double kFlatWeight = 10;    // of the term that holds vertices where the surface bends
constexpr int kSizeSmoothings = 8;    // of the target areas
constexpr double kSoftness = 0.03;    // of a ring's mean doubled area: where chi bends
constexpr double kLeastCosine = 0.4;  // between a triangle and the surface: leaning more costs as if area were lost
constexpr double kStill = 0.03;       // of the edges' length: vertices whose surroundings moved less wait
constexpr unsigned kSweepsOfAim = 10;
constexpr int kStepHalvings = 3;
constexpr double kLeastGain = 1e-4;  // of the energy: a smaller one is not worth a step

/// Mean over each vertex and its neighbours, several times.
void smooth(const Rings& rings, std::vector<double>& size) {
    const auto V = static_cast<std::uint32_t>(size.size());
    std::vector<double> next(V);
    for (int round = 0; round < kSizeSmoothings; ++round) {
        for (std::uint32_t v = 0; v < V; ++v) {
            double sum = 0;
            for (const RingTriangle& t : rings.at(v)) sum += size[t.first] + size[t.second];
            next[v] = 0.25 * size[v] + 0.375 * sum / static_cast<double>(rings.at(v).size());
        }
        size.swap(next);
    }
}

/// A place on the surface for a vertex.
struct Place {
    Vec3 position;
    Vec3 normal;  // zero for a fixed vertex: two surfaces may meet there
};

class Relaxation {
 public:
    Relaxation(const SurfaceWalk& surface, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
               std::vector<FacePoint>& points)
        : surface_(surface),
          triangles_(triangles),
          rings_(triangles, points.size()),
          targets_(triangles.size()),
          points_(points),
          moved_(points.size()) {
        for (std::size_t v = 0; v < points.size(); ++v)
            places_.push_back({surface.position(points[v]), fixed[v] != 0 ? Vec3{} : surface.normal(points[v])});
    }

    /// Sets the doubled areas that the triangles aim at: what they have around each vertex, smoothed. So the density of
    /// the vertices stays, but for what changes from one triangle to the next, and for `factors` (V, or empty).
    void aim(std::span<const double> factors) {
        const auto V = static_cast<std::uint32_t>(places_.size());
        std::vector<double> size(V);
        for (std::uint32_t v = 0; v < V; ++v) {
            const Vec3& p = places_[v].position;
            for (const RingTriangle& t : rings_.at(v))
                size[v] += length(cross(places_[t.first].position - p, places_[t.second].position - p));
            size[v] /= static_cast<double>(rings_.at(v).size());
            if (!factors.empty()) size[v] *= factors[v];
        }
        smooth(rings_, size);
        for (std::size_t t = 0; t < triangles_.size(); ++t) {
            const Face& f = triangles_[t];
            targets_[t] = (size[f[0]] + size[f[1]] + size[f[2]]) / 3;
        }
    }

    [[nodiscard]] const Rings& rings() const { return rings_; }

    /// Moves v to where the energy around it is lower, if a step finds such a place; nothing where all was still of
    /// late.
    void improve(std::uint32_t v, std::uint32_t sweep) {
        if (!is_restless(v, sweep)) return;
        const Place& here = places_[v];
        if (squared_length(here.normal) == 0) return;
        const double softness = kSoftness * 0.5 * std::sqrt(3.0) * squared_size_of_ring(v);
        Vec3 step;
        const double energy = energy_at(v, here, softness, &step);
        for (int halving = 0; halving <= kStepHalvings; ++halving, step = step * 0.5) {
            const FacePoint to = surface_.walk(points_[v], step);
            const Place there{surface_.position(to), surface_.normal(to)};
            if (squared_length(there.normal) == 0) continue;
            if (!(energy_at(v, there, softness, nullptr) < energy * (1 - kLeastGain))) continue;
            if (squared_length(there.position - here.position) > kStill * kStill * squared_size_of_ring(v))
                moved_[v] = sweep;
            points_[v] = to;
            places_[v] = there;
            return;
        }
    }

 private:
    /// Mean squared length of the edges at v.
    [[nodiscard]] double squared_size_of_ring(std::uint32_t v) {
        double sum = 0;
        for (const RingTriangle& t : rings_.at(v))
            sum += squared_length(places_[t.first].position - places_[v].position);
        return sum / static_cast<double>(rings_.at(v).size());
    }

    [[nodiscard]] bool is_restless(std::uint32_t v, std::uint32_t sweep) {
        std::uint32_t last = moved_[v];
        for (const RingTriangle& t : rings_.at(v)) last = std::max({last, moved_[t.first], moved_[t.second]});
        return last + 1 >= sweep;
    }

    /// The energy of v's ring with v at `here`; newton: out, where asked for, a step in the tangent plane.
    [[nodiscard]] double energy_at(std::uint32_t v, const Place& here, double softness, Vec3* newton) {
        const Vec3& n = here.normal;
        const Vec3 x = normalized(cross(n, std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0})), y = cross(n, x);
        double energy = 0, gx = 0, gy = 0, hxx = 0, hxy = 0, hyy = 0;
        for (const RingTriangle& t : rings_.at(v)) {
            const Vec3 a = places_[t.first].position - here.position, b = places_[t.second].position - here.position;
            const Vec3 c = b - a, ab = cross(a, b);
            const double S = squared_length(a) + squared_length(b) + squared_length(c);
            const Vec3 up = normalized(n + places_[t.first].normal + places_[t.second].normal);
            const double area = length(ab), seen = dot(up, ab);
            const bool upright = seen >= kLeastCosine * area;
            const double D = upright ? area : seen / kLeastCosine;
            const double root = std::sqrt(D * D + softness * softness);
            // For D far below 0 the sum would cancel.
            const double chi = D >= 0 ? 0.5 * (D + root) : 0.5 * softness * softness / (root - D);
            const double A = targets_[t.triangle];
            const bool smooth = squared_length(places_[t.first].normal) > 0;
            const double bend = smooth ? dot(a, n - places_[t.first].normal) : 0;
            energy += S / chi + kSizeWeight * (chi / A + A / chi) + kFlatWeight * bend * bend / A;
            if (!newton || area == 0) continue;
            const double slope = chi / root;  // of chi over D
            const Vec3 dS = (a + b) * -2.0, dD = cross(upright ? ab / area : up / kLeastCosine, c);
            const double r = 1 / chi;
            const double push = (S * r * r + kSizeWeight * (A * r * r - 1 / A)) * slope;
            const double curve = 2 * (S + kSizeWeight * A) * r * r * r * slope * slope;
            const double dx = dot(dD, x), dy = dot(dD, y);
            gx += dot(dS, x) * r - push * dx;
            gy += dot(dS, y) * r - push * dy;
            hxx += 4 * r + curve * dx * dx;
            hxy += curve * dx * dy;
            hyy += 4 * r + curve * dy * dy;
        }
        const double det = hxx * hyy - hxy * hxy;
        if (newton && det > 0) *newton = x * ((hxy * gy - hyy * gx) / det) + y * ((hxy * gx - hxx * gy) / det);
        return energy;
    }

    const SurfaceWalk& surface_;
    const std::vector<Face>& triangles_;
    const Rings rings_;
    std::vector<double> targets_;  // doubled area of each triangle
    std::vector<FacePoint>& points_;
    std::vector<Place> places_;
    std::vector<std::uint32_t> moved_;  // the last sweep in which each vertex moved
};

}  // namespace

void relax(const SurfaceWalk& surface, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
           const RelaxOptions& options, std::vector<FacePoint>& points) {
    Relaxation relaxation(surface, triangles, fixed, points);
    const auto groups = relaxation.rings().independent_groups(fixed);
    for (std::uint32_t sweep = 1; sweep <= options.sweeps; ++sweep) {
        if (sweep % kSweepsOfAim == 1) relaxation.aim(sweep == 1 ? options.area_factors : std::span<const double>{});
        for (const auto& group : groups)
            parallel_slices(group.size(), options.threads, [&](std::size_t begin, std::size_t end) {
                for (std::size_t k = begin; k < end; ++k) relaxation.improve(group[k], sweep);
            });
    }
}

}  // namespace mvw
