#include "codec/remesh/relax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

#include "codec/remesh/parallel.h"

namespace mvw {

namespace {

constexpr double kSizeWeight = 10;    // of the area term against the shape term
constexpr double kFlatWeight = 10;    // of the term that holds vertices where the surface bends
constexpr int kSizeSmoothings = 8;    // of the target areas
constexpr double kSoftness = 0.03;    // of a ring's mean doubled area: where chi bends
constexpr double kLeastCosine = 0.4;  // between a triangle and the surface: leaning more costs as if area were lost
constexpr int kStepHalvings = 3;
constexpr double kLeastGain = 1e-4;  // of the energy: a smaller one is not worth a step

/// One triangle around a vertex v: its corners behind v, and what its doubled area should be.
struct RingTriangle {
    std::uint32_t first = 0, second = 0;
    float target = 0;
};

/// The triangles around all vertices.
struct Rings {
    std::vector<std::uint32_t> begin;  // V + 1
    std::vector<RingTriangle> triangles;

    [[nodiscard]] std::span<RingTriangle> at(std::uint32_t v) {
        return std::span(triangles).subspan(begin[v], begin[v + 1] - begin[v]);
    }
};

Rings rings_of(const std::vector<Face>& triangles, std::size_t vertices) {
    Rings rings;
    rings.begin.assign(vertices + 1, 0);
    for (const Face& f : triangles)
        for (const std::uint32_t v : f) ++rings.begin[v + 1];
    std::partial_sum(rings.begin.begin(), rings.begin.end(), rings.begin.begin());
    rings.triangles.resize(triangles.size() * 3);
    std::vector<std::uint32_t> at(rings.begin.begin(), rings.begin.end() - 1);
    for (const Face& f : triangles)
        for (std::size_t k = 0; k < 3; ++k) rings.triangles[at[f[k]]++] = {f[(k + 1) % 3], f[(k + 2) % 3]};
    return rings;
}

/// Doubled areas for the triangles to aim at: what they have around each vertex, smoothed. So the density of the
/// vertices stays, but for what changes from one triangle to the next.
void set_targets(const std::vector<Vec3>& positions, Rings& rings) {
    const auto V = static_cast<std::uint32_t>(positions.size());
    std::vector<double> size(V), next(V);
    for (std::uint32_t v = 0; v < V; ++v) {
        for (const RingTriangle& t : rings.at(v))
            size[v] += length(cross(positions[t.first] - positions[v], positions[t.second] - positions[v]));
        size[v] /= static_cast<double>(rings.at(v).size());
    }
    for (int round = 0; round < kSizeSmoothings; ++round) {
        for (std::uint32_t v = 0; v < V; ++v) {
            double sum = 0;
            for (const RingTriangle& t : rings.at(v)) sum += size[t.first] + size[t.second];
            next[v] = 0.25 * size[v] + 0.375 * sum / static_cast<double>(rings.at(v).size());
        }
        size.swap(next);
    }
    for (std::uint32_t v = 0; v < V; ++v)
        for (RingTriangle& t : rings.at(v))
            t.target = static_cast<float>((size[v] + size[t.first] + size[t.second]) / 3);
}

/// Groups the vertices that move so that no two of a group are neighbours.
std::vector<std::vector<std::uint32_t>> color_groups(Rings& rings, const std::vector<std::uint8_t>& fixed) {
    constexpr std::uint8_t kNoColor = 64;
    std::vector<std::vector<std::uint32_t>> groups;
    std::vector<std::uint8_t> color(fixed.size(), kNoColor);
    for (std::uint32_t v = 0; v < fixed.size(); ++v) {
        if (fixed[v]) continue;
        std::uint64_t used = 0;
        for (const RingTriangle& t : rings.at(v))
            for (const std::uint32_t u : {t.first, t.second})
                if (color[u] != kNoColor) used |= std::uint64_t{1} << color[u];
        std::uint8_t c = 0;
        while (c + 1 < kNoColor && (used >> c & 1) != 0) ++c;
        color[v] = c;
        if (c >= groups.size()) groups.resize(c + 1u);
        groups[c].push_back(v);
    }
    return groups;
}

/// A place on the surface for a vertex.
struct Place {
    Vec3 position, normal;
};

class Relaxation {
 public:
    Relaxation(const SurfaceWalk& surface, const std::vector<Face>& triangles, std::vector<FacePoint>& points)
        : surface_(surface), rings_(rings_of(triangles, points.size())), points_(points) {
        std::vector<Vec3> positions;
        for (const FacePoint& p : points) {
            places_.push_back({surface.position(p), surface.normal(p)});
            positions.push_back(places_.back().position);
        }
        set_targets(positions, rings_);
    }

    [[nodiscard]] Rings& rings() { return rings_; }

    /// Moves v to where the energy around it is lower, if a step finds such a place.
    void improve(std::uint32_t v) {
        const Place& here = places_[v];
        if (squared_length(here.normal) == 0) return;
        const double softness = softness_of_ring(v);
        Vec3 step;
        const double energy = energy_at(v, here, softness, &step);
        for (int halving = 0; halving <= kStepHalvings; ++halving, step = step * 0.5) {
            const FacePoint to = surface_.walk(points_[v], step);
            const Place there{surface_.position(to), surface_.normal(to)};
            if (squared_length(there.normal) == 0) continue;
            if (!(energy_at(v, there, softness, nullptr) < energy * (1 - kLeastGain))) continue;
            points_[v] = to;
            places_[v] = there;
            return;
        }
    }

 private:
    [[nodiscard]] double softness_of_ring(std::uint32_t v) {
        double sum = 0;
        for (const RingTriangle& t : rings_.at(v))
            sum += squared_length(places_[t.first].position - places_[v].position);
        return kSoftness * 0.5 * std::sqrt(3.0) * sum / static_cast<double>(rings_.at(v).size());
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
            const double area = length(ab), seen = dot(n, ab);
            const bool upright = seen >= kLeastCosine * area;
            const double D = upright ? area : seen / kLeastCosine;
            const double root = std::sqrt(D * D + softness * softness);
            // For D far below 0 the sum would cancel.
            const double chi = D >= 0 ? 0.5 * (D + root) : 0.5 * softness * softness / (root - D);
            const double A = t.target;
            const double bend = dot(a, n - places_[t.first].normal);
            energy += S / chi + kSizeWeight * (chi / A + A / chi) + kFlatWeight * bend * bend / A;
            if (!newton || area == 0) continue;
            const double slope = chi / root;  // of chi over D
            const Vec3 dS = (a + b) * -2.0, dD = cross(upright ? ab / area : n / kLeastCosine, c);
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
    Rings rings_;
    std::vector<FacePoint>& points_;
    std::vector<Place> places_;
};

}  // namespace

void relax(const SurfaceWalk& surface, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
           const RelaxOptions& options, std::vector<FacePoint>& points) {
    Relaxation relaxation(surface, triangles, points);
    const auto groups = color_groups(relaxation.rings(), fixed);
    for (unsigned sweep = 0; sweep < options.sweeps; ++sweep)
        for (const auto& group : groups)
            parallel_slices(group.size(), options.threads, [&](std::size_t begin, std::size_t end) {
                for (std::size_t k = begin; k < end; ++k) relaxation.improve(group[k]);
            });
}

}  // namespace mvw
