#include "codec/remesh/drift.h"

#include <algorithm>
#include <cmath>

#include "codec/remesh/parallel.h"

namespace mvw {

namespace {

constexpr double kMostGrowth = 1.7;
constexpr double kLeastQuality = 0.2;  // a triangle that is shaped better than this may get worse
constexpr double kLeastCosine = 0.4;   // between a triangle and the surface; leaning more counts as worse shape
constexpr int kHalvings = 2;

double squared_longest(const Vec3& a, const Vec3& b, const Vec3& c) {
    return std::max({squared_length(b - a), squared_length(c - b), squared_length(a - c)});
}

/// 1 for an equilateral triangle flat on the surface, 0 for a degenerate or upended one, less where it looks away from
/// `outside` (of any length; zero: not known).
double quality(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& outside) {
    const Vec3 n = cross(b - a, c - a);
    const double sum = squared_length(b - a) + squared_length(c - b) + squared_length(a - c);
    const double area = length(n), across = length(outside);
    const double seen = across > 0 ? dot(n, outside) / (across * kLeastCosine) : area;
    return sum > 0 ? 2 * std::sqrt(3.0) * std::min(area, seen) / sum : 0;
}

}  // namespace

Drift::Drift(const SurfaceWalk& surface, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
             std::vector<FacePoint> points, unsigned threads)
    : surface_(surface),
      rings_(triangles, points.size()),
      threads_(threads),
      fixed_(fixed),
      groups_(rings_.independent_groups(fixed)),
      points_(std::move(points)) {
    places_.reserve(points_.size());
    for (std::uint32_t v = 0; v < points_.size(); ++v) places_.push_back(place_of(v, points_[v]));
    most_.reserve(triangles.size());
    for (const Face& f : triangles)
        most_.push_back(squared_longest(position(f[0]), position(f[1]), position(f[2])) * kMostGrowth * kMostGrowth);
}

Drift::Place Drift::place_of(std::uint32_t v, const FacePoint& p) const {
    return {surface_.position(p), fixed_[v] != 0 ? Vec3{} : surface_.normal(p)};
}

bool Drift::stands(std::uint32_t v, const Place& there) const {
    const Place& here = places_[v];
    return std::ranges::all_of(rings_.at(v), [&](const RingTriangle& t) {
        const Place &b = places_[t.first], &c = places_[t.second];
        const double after = quality(there.position, b.position, c.position, there.normal + b.normal + c.normal);
        if (after < kLeastQuality &&
            after < quality(here.position, b.position, c.position, here.normal + b.normal + c.normal))
            return false;
        const double longest = squared_longest(there.position, b.position, c.position);
        return longest <= most_[t.triangle] || longest <= squared_longest(here.position, b.position, c.position);
    });
}

bool Drift::put(std::uint32_t v, const FacePoint& where) {
    const Place there = place_of(v, where);
    if (!stands(v, there)) return false;
    points_[v] = where;
    places_[v] = there;
    return true;
}

std::vector<Vec3> Drift::normals() const {
    std::vector<Vec3> out;
    out.reserve(places_.size());
    for (const Place& p : places_) out.push_back(p.normal);
    return out;
}

void Drift::move(const std::vector<Vec3>& steps) {
    for (const auto& group : groups_)
        parallel_slices(group.size(), threads_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t v = group[k];
                Vec3 step = steps[v];
                for (int halving = 0; halving <= kHalvings; ++halving, step = step * 0.5)
                    if (put(v, surface_.walk(points_[v], step))) break;
            }
        });
}

std::vector<FacePoint> closest_points(const ReferenceSurface& surface, const std::vector<Vec3>& positions,
                                      unsigned threads) {
    std::vector<FacePoint> points(positions.size());
    parallel_slices(points.size(), threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const SurfacePoint hit = surface.closest(positions[v], begin < v ? points[v - 1].face : kNone);
            points[v] = {hit.face, hit.barycentric};
        }
    });
    return points;
}

}  // namespace mvw
