#include "codec/enc_slide.h"

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
constexpr unsigned kUntanglings = 40;  // passes that take moves back; then the whole round is taken back
constexpr double kMostLoss = 1.5;      // of the distance from the input, before to after
constexpr std::uint32_t kSamples = 40'000;

Vec3 scaled_normal(const std::vector<Vec3>& positions, const Face& f) {
    return cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]);
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
        if (!untangle(on)) return;
        positions_.swap(moved_);
        on_.swap(on);
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            if (upright_[t] == 0) upright_[t] = stands(t, positions_, on_);
    }

    [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }
    [[nodiscard]] const std::vector<Face>& triangles() const { return triangles_; }
    [[nodiscard]] const std::vector<std::uint8_t>& fixed() const { return fixed_; }

    /// Of the input where each vertex is; vertices that never moved keep theirs.
    void color(std::vector<Rgba8>& colors) const {
        for (std::size_t v = 0; v < colors.size(); ++v) {
            if (fixed_[v] != 0) continue;
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
        for (std::size_t v = mesh_.base.vertex_count(); v < details.size(); ++v)
            if (fixed_[v] == 0) details[v].y *= kKept, details[v].z *= kKept;
        transform_.synthesize(details, mesh_.levels, positions);
        return positions;
    }

    /// Whether a triangle looks to the side that the input does at its corners.
    [[nodiscard]] std::uint8_t stands(std::size_t t, const std::vector<Vec3>& positions,
                                      const std::vector<SurfacePoint>& on) const {
        const Face& f = triangles_[t];
        const Vec3 outside = normals_[on[f[0]].face] + normals_[on[f[1]].face] + normals_[on[f[2]].face];
        return dot(scaled_normal(positions, f), outside) > 0 ? 1 : 0;
    }

    /// Takes back the moves of corners of triangles that fall; a move taken back can fell the next one. False where
    /// that does not end.
    bool untangle(std::vector<SurfacePoint>& on) {
        for (unsigned pass = 0; pass < kUntanglings; ++pass) {
            bool fallen = false;
            for (std::size_t t = 0; t < triangles_.size(); ++t) {
                if (upright_[t] == 0 || stands(t, moved_, on) != 0) continue;
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
    PatchTransform transform_;
    std::vector<Vec3> positions_;
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
    unfold(slide.triangles(), slide.fixed(), positions);
    if (distance_of(unit, slide.triangles(), positions, threads) > kMostLoss * before) return;
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (slide.fixed()[v] == 0) mesh.positions[v] = positions[v] * box.diagonal() + box.center();
    slide.color(mesh.colors);
}

}  // namespace mvw
