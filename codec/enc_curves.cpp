#include "codec/enc_curves.h"

#include <algorithm>

namespace mvw {

namespace {

constexpr double kLeastGap = 0.15;  // between neighbours on a line, of what it was at first
constexpr double kMostCut = 2e-4;   // in coded units: vertices that hold more of a bend than this stay

}  // namespace

LineCurve::LineCurve(std::vector<std::uint32_t> vertices, const std::vector<Vec3>& positions)
    : vertices_(std::move(vertices)) {
    for (std::size_t t = 0; t < vertices_.size(); ++t) {
        points_.push_back(positions[vertices_[t]]);
        places_.push_back(static_cast<double>(t));
    }
    for (std::size_t t = 0; t < points_.size(); ++t)
        stays_.push_back(t == 0 || t + 1 == points_.size() || is_bend(t) ? 1 : 0);
}

bool LineCurve::is_bend(std::size_t t) const {
    const Vec3 chord = points_[t + 1] - points_[t - 1];
    return squared_length(cross(points_[t] - points_[t - 1], chord)) > kMostCut * kMostCut * squared_length(chord);
}

double LineCurve::nearest(const Vec3& p) const {
    double best = 1e300, place = 0;
    for (std::size_t k = 0; k + 1 < points_.size(); ++k) {
        const Vec3 along = points_[k + 1] - points_[k];
        const double squared = squared_length(along);
        const double t = squared > 0 ? std::clamp(dot(p - points_[k], along) / squared, 0.0, 1.0) : 0.0;
        const double distance = squared_length(points_[k] + along * t - p);
        if (distance < best) best = distance, place = static_cast<double>(k) + t;
    }
    return place;
}

Vec3 LineCurve::at(double place) const {
    const std::size_t k = std::min(static_cast<std::size_t>(place), points_.size() - 2);
    return points_[k] + (points_[k + 1] - points_[k]) * (place - static_cast<double>(k));
}

void LineCurve::slide(const ReferenceSurface& reference, const std::vector<Vec3>& wanted, Drift& drift,
                      std::vector<Vec3>& positions) {
    for (std::size_t t = 1; t + 1 < vertices_.size(); ++t) {
        if (stays_[t] != 0) continue;
        const std::uint32_t v = vertices_[t];
        const double least = places_[t - 1] + kLeastGap, most = places_[t + 1] - kLeastGap;
        if (least > most) continue;
        const double place = std::clamp(nearest(wanted[v]), least, most);
        const Vec3 position = at(place);
        const SurfacePoint hit = reference.closest(position, drift.points()[v].face);
        if (!drift.put(v, {hit.face, hit.barycentric})) continue;
        places_[t] = place;
        positions[v] = position;
    }
}

std::vector<LineCurve> curves_of(const SemiRegularMesh& mesh, const std::vector<std::uint8_t>& on_line) {
    std::vector<LineCurve> curves;
    const std::uint32_t n = 1u << mesh.levels;
    for (const BaseEdge& e : mesh.base.edges()) {
        std::vector<std::uint32_t> vertices;
        for (std::uint32_t t = 0; t <= n; ++t) vertices.push_back(edge_vertex_index(mesh.base, e, mesh.levels, t));
        if (on_line[vertices[n / 2]] != 0) curves.emplace_back(std::move(vertices), mesh.positions);
    }
    return curves;
}

}  // namespace mvw
