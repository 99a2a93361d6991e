#include "codec/enc_slide.h"

#include <algorithm>
#include <cmath>

#include "codec/measure/surface_error.h"
#include "codec/measure/surface_index.h"
#include "codec/remesh/drift.h"
#include "codec/remesh/features.h"
#include "codec/remesh/fit.h"
#include "codec/remesh/resample.h"
#include "codec/remesh/surface_walk.h"
#include "codec/remesh/unfold.h"

namespace mvw {

namespace {

constexpr unsigned kRounds = 8;
constexpr float kKept = 0.5f;       // of each tangential detail, a round
constexpr double kLeastGap = 0.15;  // between neighbours on a line, of what it was at first
constexpr double kMostLoss = 1.5;   // of the distance from the input, before to after
constexpr std::uint32_t kSamples = 40'000;

/// A boundary, crease or border between two base vertices: its finest vertices, and where they were at first.
struct Curve {
    std::vector<std::uint32_t> vertices;
    std::vector<Vec3> points;
    std::vector<double> places;  // where on the curve they are now, see nearest()

    /// Place of the curve's point nearest to p: a point's number and the fraction of the way to the next.
    [[nodiscard]] double nearest(const Vec3& p) const {
        double best = 1e300, place = 0;
        for (std::size_t k = 0; k + 1 < points.size(); ++k) {
            const Vec3 along = points[k + 1] - points[k];
            const double squared = squared_length(along);
            const double t = squared > 0 ? std::clamp(dot(p - points[k], along) / squared, 0.0, 1.0) : 0.0;
            const double distance = squared_length(points[k] + along * t - p);
            if (distance < best) best = distance, place = static_cast<double>(k) + t;
        }
        return place;
    }
    [[nodiscard]] Vec3 at(double place) const {
        const std::size_t k = std::min(static_cast<std::size_t>(place), points.size() - 2);
        return points[k] + (points[k + 1] - points[k]) * (place - static_cast<double>(k));
    }
};

std::vector<Curve> curves_of(const SemiRegularMesh& mesh, const std::vector<std::uint8_t>& on_line,
                             const std::vector<Vec3>& positions) {
    std::vector<Curve> curves;
    const std::uint32_t n = 1u << mesh.levels;
    for (const BaseEdge& e : mesh.base.edges()) {
        Curve curve;
        for (std::uint32_t t = 0; t <= n; ++t) {
            const std::uint32_t i = e.side[0] == 0 ? t : e.side[0] == 1 ? n - t : 0;
            const std::uint32_t k = e.side[0] == 0 ? 0 : e.side[0] == 1 ? t : n - t;
            curve.vertices.push_back(vertex_index(mesh.base, e.face[0], mesh.levels, i, k));
            curve.points.push_back(positions[curve.vertices.back()]);
            curve.places.push_back(t);
        }
        if (on_line[curve.vertices[n / 2]] != 0) curves.push_back(std::move(curve));
    }
    return curves;
}

/// The mesh's finest vertices on their way over the input, which lies in a box of unit diagonal around the origin.
class Slide {
 public:
    Slide(const Mesh& input, const SemiRegularMesh& mesh, std::vector<Vec3> positions, const TransformOptions& options,
          unsigned threads)
        : mesh_(mesh),
          index_(input.positions, input.faces, threads),
          surface_(input, mesh.creases.empty() ? std::vector<std::uint8_t>{} : feature_half_edges(input)),
          triangles_(triangles_at_level(mesh.base, mesh.levels)),
          fixed_(line_vertices(mesh)),
          transform_(mesh.base, mesh.levels, options, mesh.creases, threads),
          positions_(std::move(positions)),
          curves_(curves_of(mesh, fixed_, positions_)),
          drift_(surface_, triangles_, fixed_, closest_points(index_, positions_, threads), threads) {}

    void round() {
        const std::vector<Vec3f> wanted = without_tangents();
        std::vector<Vec3> steps;
        for (std::uint32_t v = 0; v < positions_.size(); ++v)
            steps.push_back(to_double(wanted[v]) - drift_.position(v));
        drift_.move(steps);
        for (std::uint32_t v = 0; v < positions_.size(); ++v)
            if (fixed_[v] == 0) positions_[v] = drift_.position(v);
        for (Curve& curve : curves_) slide_along(curve, wanted);
    }

    [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }
    /// Where on the input each vertex is.
    [[nodiscard]] const std::vector<FacePoint>& points() const { return drift_.points(); }
    /// Of the input, there.
    [[nodiscard]] std::vector<Vec3> normals() const { return drift_.normals(); }
    [[nodiscard]] const std::vector<Face>& triangles() const { return triangles_; }
    [[nodiscard]] const std::vector<std::uint8_t>& fixed() const { return fixed_; }

 private:
    [[nodiscard]] FacePoint closest_point(const Vec3& p, std::uint32_t near) const {
        const SurfacePoint hit = index_.closest(p, near);
        return {hit.face, hit.barycentric};
    }

    /// The surface with each detail's tangential components shortened.
    std::vector<Vec3f> without_tangents() {
        std::vector<Vec3f> positions(positions_.size()), details(positions_.size());
        std::transform(positions_.begin(), positions_.end(), positions.begin(), to_float);
        transform_.analyze(positions, details);
        for (std::size_t v = mesh_.base.vertex_count(); v < details.size(); ++v) {
            details[v].y *= kKept;
            if (fixed_[v] == 0) details[v].z *= kKept;  // lines: along them alone
        }
        transform_.synthesize(details, mesh_.levels, positions);
        return positions;
    }

    /// Each inner vertex of a line in turn to the nearest point of where the line was at first, between its neighbours.
    void slide_along(Curve& curve, const std::vector<Vec3f>& wanted) {
        for (std::size_t t = 1; t + 1 < curve.vertices.size(); ++t) {
            const std::uint32_t v = curve.vertices[t];
            const double least = curve.places[t - 1] + kLeastGap, most = curve.places[t + 1] - kLeastGap;
            if (least > most) continue;
            const double place = std::clamp(curve.nearest(to_double(wanted[v])), least, most);
            const Vec3 position = curve.at(place);
            if (!drift_.put(v, closest_point(position, drift_.points()[v].face))) continue;
            curve.places[t] = place;
            positions_[v] = position;
        }
    }

    const SemiRegularMesh& mesh_;
    SurfaceIndex index_;
    SurfaceWalk surface_;
    std::vector<Face> triangles_;
    std::vector<std::uint8_t> fixed_;
    PatchTransform transform_;
    std::vector<Vec3> positions_;
    std::vector<Curve> curves_;
    Drift drift_;
};

double distance_of(const Mesh& input, const std::vector<Face>& triangles, const std::vector<Vec3>& positions,
                   unsigned threads) {
    return surface_error(input, {positions, triangles, {}, {}}, {kSamples, threads}).rms;
}

}  // namespace

void slide(const Mesh& input, const TransformOptions& transform, unsigned threads, SemiRegularMesh& mesh) {
    const Box box = bounding_box(input);
    const auto to_unit = [&](std::vector<Vec3> points) {
        for (Vec3& p : points) p = (p - box.center()) / box.diagonal();
        return points;
    };
    const Mesh unit{to_unit(input.positions), input.faces, input.colors, {}};
    TransformOptions in_frames = transform;
    in_frames.local_frames = true;
    Slide slide(unit, mesh, to_unit(mesh.positions), in_frames, threads);
    const double before = distance_of(unit, slide.triangles(), slide.positions(), threads);
    for (unsigned r = 0; r < kRounds; ++r) slide.round();
    std::vector<Vec3> positions = slide.positions();
    FitOptions fitting;
    fitting.threads = threads;
    fit(unit, slide.triangles(), slide.fixed(), fitting, positions);
    unfold(slide.triangles(), slide.normals(), slide.fixed(), positions);
    if (distance_of(unit, slide.triangles(), positions, threads) > kMostLoss * before) return;
    const std::vector<Vec3> start = to_unit(mesh.positions);
    for (std::size_t v = 0; v < positions.size(); ++v)  // what has not moved keeps its very bits
        if (!(positions[v] == start[v])) mesh.positions[v] = positions[v] * box.diagonal() + box.center();
    mesh.colors = colors_of(unit, slide.points());
}

}  // namespace mvw
