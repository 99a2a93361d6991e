#include "codec/enc_slide.h"

#include <algorithm>
#include <cmath>

#include "codec/measure/surface_error.h"
#include "codec/measure/surface_index.h"
#include "codec/remesh/fit.h"
#include "codec/remesh/parallel.h"
#include "codec/remesh/unfold.h"

namespace mvw {

namespace {

constexpr unsigned kRounds = 8;
constexpr float kKept = 0.5f;          // of each tangential detail, a round
constexpr double kSameSheet = 0.3;     // least cosine between the surface's normals before and after a vertex' move
constexpr double kLeastGap = 0.15;     // between neighbours on a line, of what it was at first
constexpr unsigned kUntanglings = 40;  // passes that take moves back; then the whole round is taken back
constexpr double kMostGrowth = 1.7;    // of a triangle's longest side: vertices must not leave tips and ridges bare
constexpr double kMostLoss = 1.5;      // of the distance from the input, before to after
constexpr std::uint32_t kSamples = 40'000;

Vec3 scaled_normal(const std::vector<Vec3>& positions, const Face& f) {
    return cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]);
}

/// A boundary, crease or border between two base vertices: its finest vertices, and where they were at first.
struct Curve {
    std::vector<std::uint32_t> vertices;
    std::vector<Vec3> points;

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
        : input_(input),
          mesh_(mesh),
          threads_(threads),
          index_(input.positions, input.faces, threads),
          triangles_(triangles_at_level(mesh.base, mesh.levels)),
          fixed_(line_vertices(mesh)),
          transform_(mesh.base, mesh.levels, options, mesh.creases, threads),
          positions_(std::move(positions)),
          curves_(curves_of(mesh, fixed_, positions_)),
          on_(positions_.size()),
          moved_(positions_.size()) {
        normals_.reserve(input.faces.size());
        for (const Face& f : input.faces) normals_.push_back(normalized(scaled_normal(input.positions, f)));
        parallel_slices(positions_.size(), threads_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v)
                on_[v] = index_.closest(positions_[v], begin < v ? on_[v - 1].face : kNone);
        });
        upright_.resize(triangles_.size());
        for (std::size_t t = 0; t < triangles_.size(); ++t) upright_[t] = stands(t, positions_, on_);
        for (const Face& f : triangles_) most_.push_back(longest(f, positions_) * kMostGrowth);
    }

    void round() {
        const std::vector<Vec3f> wanted = without_tangents();
        moved_ = positions_;
        std::vector<SurfacePoint> on = on_;
        parallel_slices(positions_.size(), threads_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                if (fixed_[v] != 0) continue;
                const SurfacePoint hit = index_.closest(to_double(wanted[v]), on_[v].face);
                if (dot(normals_[hit.face], normals_[on_[v].face]) < kSameSheet) continue;
                on[v] = hit;
                moved_[v] = hit.point;
            }
        });
        for (const Curve& curve : curves_) slide_along(curve, wanted, on);
        if (!untangle(on)) return;
        positions_.swap(moved_);
        on_.swap(on);
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            if (upright_[t] == 0) upright_[t] = stands(t, positions_, on_);
    }

    [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }
    /// Of the input where each vertex is.
    [[nodiscard]] std::vector<Vec3> normals() const {
        std::vector<Vec3> out;
        for (const SurfacePoint& p : on_) out.push_back(normals_[p.face]);
        return out;
    }
    [[nodiscard]] const std::vector<Face>& triangles() const { return triangles_; }
    [[nodiscard]] const std::vector<std::uint8_t>& fixed() const { return fixed_; }

    /// Of the input where each vertex is.
    void color(std::vector<Rgba8>& colors) const {
        for (std::size_t v = 0; v < colors.size(); ++v) {
            const Face& f = input_.faces[on_[v].face];
            std::array<double, 4> sum{0.5, 0.5, 0.5, 0.5};
            for (std::size_t k = 0; k < 3; ++k) {
                const Rgba8& c = input_.colors[f[k]];
                const std::array<std::uint8_t, 4> channel{c.r, c.g, c.b, c.a};
                for (std::size_t i = 0; i < 4; ++i) sum[i] += on_[v].barycentric[k] * channel[i];
            }
            const auto byte = [](double x) { return static_cast<std::uint8_t>(x); };
            colors[v] = {byte(sum[0]), byte(sum[1]), byte(sum[2]), byte(sum[3])};
        }
    }

 private:
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

    /// The inner vertices of a line, to the nearest points of where it was at first; all of them, or none where that
    /// would change their order.
    void slide_along(const Curve& curve, const std::vector<Vec3f>& wanted, std::vector<SurfacePoint>& on) {
        std::vector<double> place(curve.vertices.size(), 0);
        place.back() = static_cast<double>(curve.vertices.size() - 1);
        for (std::size_t t = 1; t + 1 < place.size(); ++t)
            place[t] = curve.nearest(to_double(wanted[curve.vertices[t]]));
        for (std::size_t t = 1; t < place.size(); ++t)
            if (place[t] < place[t - 1] + kLeastGap) return;
        for (std::size_t t = 1; t + 1 < place.size(); ++t) {
            const std::uint32_t v = curve.vertices[t];
            moved_[v] = curve.at(place[t]);
            on[v] = index_.closest(moved_[v], on_[v].face);
        }
    }

    /// Whether a triangle looks to the side that the input does at its corners.
    [[nodiscard]] std::uint8_t stands(std::size_t t, const std::vector<Vec3>& positions,
                                      const std::vector<SurfacePoint>& on) const {
        const Face& f = triangles_[t];
        const Vec3 outside = normals_[on[f[0]].face] + normals_[on[f[1]].face] + normals_[on[f[2]].face];
        return dot(scaled_normal(positions, f), outside) > 0 ? 1 : 0;
    }

    /// Of a triangle's sides, model units.
    static double longest(const Face& f, const std::vector<Vec3>& positions) {
        const Vec3 &a = positions[f[0]], &b = positions[f[1]], &c = positions[f[2]];
        return std::sqrt(std::max({squared_length(b - a), squared_length(c - b), squared_length(a - c)}));
    }

    /// Takes back the moves of corners of triangles that fall or are drawn out; a move taken back can fell the next
    /// one. False where that does not end.
    bool untangle(std::vector<SurfacePoint>& on) {
        for (unsigned pass = 0; pass < kUntanglings; ++pass) {
            bool fallen = false;
            for (std::size_t t = 0; t < triangles_.size(); ++t) {
                const bool falls = upright_[t] != 0 && stands(t, moved_, on) == 0;
                if (!falls && longest(triangles_[t], moved_) <= most_[t]) continue;
                fallen = true;
                for (const std::uint32_t v : triangles_[t]) moved_[v] = positions_[v], on[v] = on_[v];
            }
            if (!fallen) return true;
        }
        return false;
    }

    const Mesh& input_;
    const SemiRegularMesh& mesh_;
    unsigned threads_;
    SurfaceIndex index_;
    std::vector<Vec3> normals_;  // of the input's faces
    std::vector<Face> triangles_;
    std::vector<std::uint8_t> fixed_, upright_;
    std::vector<double> most_;  // of each triangle's longest side
    PatchTransform transform_;
    std::vector<Vec3> positions_;
    std::vector<Curve> curves_;
    std::vector<SurfacePoint> on_;  // where on the input each vertex is
    std::vector<Vec3> moved_;
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
    slide.color(mesh.colors);
}

}  // namespace mvw
