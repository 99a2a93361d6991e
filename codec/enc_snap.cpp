#include "codec/enc_snap.h"

#include <algorithm>
#include <cmath>

#include "codec/remesh/drift.h"
#include "codec/remesh/features.h"
#include "codec/remesh/fit.h"
#include "codec/remesh/surface_walk.h"
#include "codec/remesh/unfold.h"

namespace mvw {

namespace {

constexpr unsigned kRounds = 5;
constexpr float kKept = 0.5f;     // of each tangential detail, a round, as in enc_slide.cpp
constexpr double kMostCells = 2;  // from a grid point along its normal; farther away another one is better

std::array<std::int32_t, 3> rounded(const Vec3& p, unsigned bits) {
    std::array<std::int32_t, 3> g{};
    for (std::size_t k = 0; k < 3; ++k)
        g[k] = static_cast<std::int32_t>(std::lround(std::ldexp(p[k], static_cast<int>(bits))));
    return g;
}

class Snap {
 public:
    Snap(const Mesh& input, const TransformOptions& transform, unsigned bits, unsigned threads, SemiRegularMesh& mesh)
        : input_(input),
          mesh_(mesh),
          threads_(threads),
          surface_(input, mesh.creases.empty() ? std::vector<std::uint8_t>{} : feature_half_edges(input)),
          triangles_(triangles_at_level(mesh.base, mesh.levels)),
          fixed_(line_vertices(mesh)),
          transform_(mesh.base, mesh.levels, transform, mesh.creases, threads),
          coefficients_(mesh.positions.size()),
          wanted_(mesh.positions.size()),
          drift_(surface_, triangles_, fixed_,
                 closest_points({input.positions, input.faces, threads}, mesh.positions, threads), threads) {
        for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
            above_.push_back(mesh.positions[v] - drift_.position(v));
        params_.base_bits = static_cast<std::uint8_t>(bits);
        params_.transform = transform;
        analyze();
        for (std::uint32_t v = 0; v < mesh.base.vertex_count(); ++v)
            grid_.push_back(rounded(to_double(coefficients_[v]), bits));
        units_ = PartUnits(mesh.base, mesh.creases, mesh.materials, grid_, params_);
    }

    void round() {
        want();
        std::vector<Vec3> steps;
        for (std::uint32_t v = 0; v < above_.size(); ++v)
            steps.push_back(to_double(wanted_[v]) - above_[v] - drift_.position(v));
        drift_.move(steps);
        for (std::uint32_t v = 0; v < above_.size(); ++v)
            if (fixed_[v] == 0) mesh_.positions[v] = drift_.position(v) + above_[v];
        analyze();
    }

    /// Vertices on the surface are not those that come nearest to it.
    void fit_to_input() {
        FitOptions fitting;
        fitting.threads = threads_;
        fit(input_, triangles_, fixed_, fitting, mesh_.positions);
        unfold(triangles_, drift_.normals(), fixed_, mesh_.positions);
        analyze();
    }

    /// Vertices on lines, and those that have ended far from their grid points, take the nearest ones.
    PartUnits::Grid grid() {
        for (std::uint32_t v = 0; v < grid_.size(); ++v) {
            const double gap = length(to_double(coefficients_[v] - units_.origin(v)));
            if (fixed_[v] != 0 || gap > kMostCells * params_.grid())
                grid_[v] = rounded(to_double(coefficients_[v]), params_.base_bits);
        }
        return grid_;
    }

 private:
    void analyze() {
        std::transform(mesh_.positions.begin(), mesh_.positions.end(), wanted_.begin(), to_float);
        transform_.analyze(wanted_, coefficients_);
    }

    /// The surface whose coarse positions lie on the normals.
    void want() {
        for (std::uint32_t v = 0; v < grid_.size(); ++v) {
            if (fixed_[v] != 0) continue;
            const Vec3f& n = units_.frame(v).n;
            coefficients_[v] = units_.origin(v) + n * dot(n, coefficients_[v] - units_.origin(v));
        }
        for (std::size_t v = grid_.size(); v < coefficients_.size(); ++v) {
            coefficients_[v].y *= kKept;
            if (fixed_[v] == 0) coefficients_[v].z *= kKept;
        }
        transform_.synthesize(coefficients_, mesh_.levels, wanted_);
    }

    const Mesh& input_;
    SemiRegularMesh& mesh_;
    const unsigned threads_;
    const SurfaceWalk surface_;
    const std::vector<Face> triangles_;
    const std::vector<std::uint8_t> fixed_;
    PatchTransform transform_;
    PartParams params_;
    PartUnits::Grid grid_;
    PartUnits units_;
    std::vector<Vec3f> coefficients_, wanted_;
    Drift drift_;
    std::vector<Vec3> above_;  // from the vertices' places on the input to the vertices
};

}  // namespace

PartUnits::Grid snap(const Mesh& input, const TransformOptions& transform, unsigned bits, unsigned threads,
                     SemiRegularMesh& mesh) {
    Snap snap(input, transform, bits, threads, mesh);
    for (unsigned r = 0; r < kRounds; ++r) snap.round();
    snap.fit_to_input();
    return snap.grid();
}

}  // namespace mvw
