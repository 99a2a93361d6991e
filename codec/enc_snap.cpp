#include "codec/enc_snap.h"

#include <algorithm>
#include <cmath>

#include "codec/measure/surface_index.h"
#include "codec/remesh/fit.h"
#include "codec/remesh/parallel.h"
#include "codec/remesh/unfold.h"

namespace mvw {

namespace {

constexpr unsigned kRounds = 5;
constexpr float kKept = 0.5f;          // of each tangential detail, a round, as in enc_slide.cpp
constexpr unsigned kUntanglings = 20;  // passes over the triangles that take moves back
constexpr double kSameSheet = 0.3;     // least cosine between the surface's normals before and after a vertex' move
constexpr double kMostCells = 2;       // from a grid point along its normal; farther away another one is better

Vec3 scaled_normal(const std::vector<Vec3>& positions, const Face& f) {
    return cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]);
}

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
          index_(input.positions, input.faces, threads),
          triangles_(triangles_at_level(mesh.base, mesh.levels)),
          fixed_(line_vertices(mesh)),
          normals_(mesh.positions.size()),
          transform_(mesh.base, mesh.levels, transform, mesh.creases, threads),
          coefficients_(mesh.positions.size()),
          wanted_(mesh.positions.size()) {
        parallel_slices(normals_.size(), threads_, [&](std::size_t begin, std::size_t end) {
            std::uint32_t near = kNone;
            for (std::size_t v = begin; v < end; ++v) {
                near = index_.closest(mesh.positions[v], near).face;
                normals_[v] = normal(near);
            }
        });
        params_.base_bits = static_cast<std::uint8_t>(bits);
        params_.transform = transform;
        analyze();
        for (std::uint32_t v = 0; v < mesh.base.vertex_count(); ++v)
            grid_.push_back(rounded(to_double(coefficients_[v]), bits));
        units_ = PartUnits(mesh.base, mesh.creases, mesh.materials, grid_, params_);
    }

    void round() {
        want();
        std::vector<Vec3> moved = mesh_.positions, normals = normals_;
        parallel_slices(moved.size(), threads_, [&](std::size_t begin, std::size_t end) {
            std::uint32_t near = kNone;
            for (std::size_t v = begin; v < end; ++v) {
                if (fixed_[v] != 0) continue;
                const SurfacePoint from = index_.closest(mesh_.positions[v], near);
                const Vec3 above = mesh_.positions[v] - from.point;
                const SurfacePoint to = index_.closest(to_double(wanted_[v]) - above, from.face);
                near = from.face;
                if (dot(normal(from.face), normal(to.face)) < kSameSheet) continue;
                moved[v] = to.point + above;
                normals[v] = normal(to.face);
            }
        });
        untangle(moved, normals);
        mesh_.positions.swap(moved);
        normals_.swap(normals);
        analyze();
    }

    /// Vertices on the surface are not those that come nearest to it.
    void fit_to_input() {
        FitOptions fitting;
        fitting.threads = threads_;
        fit(input_, triangles_, fixed_, fitting, mesh_.positions);
        unfold(triangles_, normals_, fixed_, mesh_.positions);
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

    [[nodiscard]] Vec3 normal(std::uint32_t face) const {
        return normalized(scaled_normal(input_.positions, input_.faces[face]));
    }

    /// Whether a triangle looks to the side that the input does at its corners.
    [[nodiscard]] static bool stands(const Face& f, const std::vector<Vec3>& positions,
                                     const std::vector<Vec3>& normals) {
        return dot(scaled_normal(positions, f), normals[f[0]] + normals[f[1]] + normals[f[2]]) > 0;
    }

    /// Takes back the moves of corners of triangles that fall; one taken back can fell the next one.
    void untangle(std::vector<Vec3>& moved, std::vector<Vec3>& normals) const {
        for (unsigned pass = 0; pass < kUntanglings; ++pass) {
            bool fallen = false;
            for (const Face& f : triangles_) {
                if (stands(f, moved, normals) || !stands(f, mesh_.positions, normals_)) continue;
                for (const std::uint32_t v : f) {
                    fallen = fallen || !(moved[v] == mesh_.positions[v]);
                    moved[v] = mesh_.positions[v];
                    normals[v] = normals_[v];
                }
            }
            if (!fallen) return;
        }
    }

    const Mesh& input_;
    SemiRegularMesh& mesh_;
    const unsigned threads_;
    const SurfaceIndex index_;
    const std::vector<Face> triangles_;
    const std::vector<std::uint8_t> fixed_;
    std::vector<Vec3> normals_;  // of the input where each vertex is
    PatchTransform transform_;
    PartParams params_;
    PartUnits::Grid grid_;
    PartUnits units_;
    std::vector<Vec3f> coefficients_, wanted_;
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
