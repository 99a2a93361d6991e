#include "codec/enc_adapt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "codec/enc_curves.h"
#include "codec/enc_lattice.h"
#include "codec/mesh/normals.h"
#include "codec/remesh/coarse_grid.h"
#include "codec/remesh/cover.h"
#include "codec/remesh/drift.h"
#include "codec/remesh/fit.h"
#include "codec/remesh/resample.h"
#include "codec/remesh/settle.h"

namespace mvw {

namespace {

constexpr unsigned kSlideRounds = 8, kSnapRounds = 5, kFitRounds = 2;
// From so many levels on, triangles of the finest one, which move by no more than themselves a round, are shorter than
// a cell of the grid.
constexpr unsigned kFineLevels = 4, kSnapRoundsOfFine = 10;
constexpr float kKept = 0.5f;         // of each tangential detail, a round
constexpr double kMostOfEdge = 0.25;  // of the shortest edge at a vertex that leads others: its step
constexpr double kSamplesOfLeader = 12;
constexpr double kMostLoss = 1.5;  // of the distance from the input, before to after sliding: points lay on ridges
constexpr std::uint32_t kSamples = 5'000, kVertexStride = 4;
constexpr double kMostCells = 2;  // from a grid point along its normal; farther away another one is better

/// positions (V) as coefficients.
void analyze(PatchTransform& transform, const std::vector<Vec3>& positions, std::vector<Vec3f>& coefficients) {
    std::vector<Vec3f> in(positions.size());
    std::transform(positions.begin(), positions.end(), in.begin(), to_float);
    coefficients.resize(positions.size());
    transform.analyze(in, coefficients);
}

/// The positions of all of `level` that coefficients (V(level)) stand for.
std::vector<Vec3> synthesized(PatchTransform& transform, const std::vector<Vec3f>& coefficients, unsigned level) {
    std::vector<Vec3f> out(coefficients.size());
    transform.synthesize(coefficients, level, out);
    std::vector<Vec3> positions(out.size());
    std::transform(out.begin(), out.end(), positions.begin(), to_double);
    return positions;
}

/// The part of displacements (V) of a surface's vertices that lies in the surface, none longer than kMostOfEdge allows.
void keep_tangential(std::span<const Vec3> positions, const std::vector<Face>& triangles,
                     std::vector<Vec3>& displacements) {
    const std::vector<Vec3> normals = vertex_normals(positions, triangles);
    std::vector<double> shortest(displacements.size(), std::numeric_limits<double>::infinity());  // edge, squared
    for (const Face& f : triangles) {
        const Vec3 &a = positions[f[0]], &b = positions[f[1]], &c = positions[f[2]];
        const double edge = std::min({squared_length(b - a), squared_length(c - b), squared_length(a - c)});
        for (const std::uint32_t v : f) shortest[v] = std::min(shortest[v], edge);
    }
    for (std::size_t v = 0; v < displacements.size(); ++v) {
        Vec3& d = displacements[v];
        d = d - normals[v] * dot(normals[v], d);
        const double most = kMostOfEdge * std::sqrt(shortest[v]), l = length(d);
        if (l > most) d = d * (most / l);
    }
}

}  // namespace

Adaptation::Adaptation(PartSurface& surface, const TransformOptions& transform, unsigned threads, SemiRegularMesh mesh)
    : surface_(surface),
      mesh_(std::move(mesh)),
      walk_(surface.walk(!mesh_.creases.empty())),
      triangles_(triangles_at_level(mesh_.base, mesh_.levels)),
      fixed_(line_vertices(mesh_)),
      options_(transform),
      points_(closest_points(surface.reference(), mesh_.positions, threads)) {}

PatchTransform Adaptation::transform(unsigned threads) const {
    return {mesh_.base, mesh_.levels, options_, mesh_.creases, threads};
}

std::vector<Vec3> Adaptation::without_tangents(PatchTransform& transform, std::vector<Vec3f>& coefficients) const {
    for (std::size_t v = mesh_.base.vertex_count(); v < coefficients.size(); ++v) {
        coefficients[v].y *= kKept;
        if (fixed_[v] == 0) coefficients[v].z *= kKept;  // lines: along them alone
    }
    return synthesized(transform, coefficients, mesh_.levels);
}

std::vector<Vec3> Adaptation::towards_fit(PatchTransform& transform, const std::vector<Vec3f>& coefficients,
                                          unsigned level, unsigned threads) const {
    const unsigned leading = level > 0 ? level - 1 : 0, shown = level + 1;
    std::vector<Vec3f> cut(coefficients.begin(),
                           coefficients.begin() + std::ptrdiff_t(vertices_at_level(mesh_.base, level)));
    cut.resize(vertices_at_level(mesh_.base, shown));
    const std::vector<Vec3> surface = synthesized(transform, cut, shown);
    const std::vector<std::uint8_t> fixed(fixed_.begin(),
                                          fixed_.begin() + std::ptrdiff_t(vertices_at_level(mesh_.base, leading)));
    FitOptions fitting;
    fitting.samples = kSamplesOfLeader;
    fitting.threads = threads;
    std::vector<Vec3> steps = fit_coarse(surface_.mesh(), mesh_.base, shown, surface, leading, fixed, fitting);
    keep_tangential(std::span(surface).first(steps.size()), triangles_at_level(mesh_.base, leading), steps);
    return interpolate(mesh_.base, leading, steps, mesh_.levels);
}

double Adaptation::distance_of(const std::vector<Vec3>& positions, unsigned threads) const {
    return surface_.reference().error_of({positions, triangles_, {}, {}}, {kSamples, threads, kVertexStride}).rms;
}

void Adaptation::slide(unsigned threads) {
    PatchTransform transform = this->transform(threads);
    Drift drift(walk_, triangles_, fixed_, points_, threads);
    std::vector<LineCurve> curves = curves_of(mesh_, fixed_);
    std::vector<Vec3> positions = mesh_.positions, steps(positions.size());
    std::vector<Vec3f> coefficients;
    for (unsigned round = 0; round < kSlideRounds; ++round) {
        analyze(transform, positions, coefficients);
        steps = towards_fit(transform, coefficients, round % mesh_.levels, threads);
        const std::vector<Vec3> wanted = without_tangents(transform, coefficients);
        for (std::uint32_t v = 0; v < steps.size(); ++v) steps[v] += wanted[v] - drift.position(v);
        drift.move(steps);
        for (std::uint32_t v = 0; v < positions.size(); ++v)
            if (fixed_[v] == 0) positions[v] = drift.position(v);
        for (LineCurve& curve : curves) curve.slide(surface_.reference(), wanted, drift, positions);
    }
    std::vector<FacePoint> points = drift.points();
    std::vector<Vec3> normals = drift.normals();
    if (cover_missed(surface_.mesh(), walk_, triangles_, fixed_, threads, points)) {
        for (std::uint32_t v = 0; v < positions.size(); ++v) {
            if (fixed_[v] != 0) continue;
            positions[v] = walk_.position(points[v]);
            normals[v] = walk_.normal(points[v]);
        }
    }
    settle(surface_.mesh(), triangles_, fixed_, normals, {kFitRounds, true, threads}, positions);
    if (distance_of(positions, threads) > kMostLoss * distance_of(mesh_.positions, threads)) return;
    mesh_.positions = std::move(positions);
    take_vertex_data(surface_.mesh(), points, mesh_);
    points_ = closest_points(surface_.reference(), mesh_.positions, threads);
}

Adaptation::Snapped Adaptation::snap(unsigned bits, unsigned threads) const {
    PatchTransform transform = this->transform(threads);
    Drift drift(walk_, triangles_, fixed_, points_, threads);
    Snapped out{mesh_, {}};
    std::vector<Vec3>& positions = out.mesh.positions;
    std::vector<Vec3> above, steps(positions.size());  // from the vertices' places on the surface to the vertices
    for (std::uint32_t v = 0; v < positions.size(); ++v) above.push_back(positions[v] - drift.position(v));
    std::vector<Vec3f> coefficients;
    analyze(transform, positions, coefficients);
    std::vector<Vec3> coarse;
    for (std::uint32_t v = 0; v < mesh_.base.vertex_count(); ++v) coarse.push_back(to_double(coefficients[v]));
    out.base = round_to_lattice(coarse, mesh_.base.faces(), bits);
    auto& [lattice, grid] = out.base;
    PartParams params;
    params.lattice = lattice;
    params.transform = options_;
    const PartUnits units(mesh_.base, mesh_.creases, mesh_.materials, grid, params);
    const auto gap = [&](std::uint32_t v) { return coefficients[v] - units.origin(v); };
    const unsigned rounds = mesh_.levels < kFineLevels ? kSnapRounds : kSnapRoundsOfFine;
    for (unsigned round = 0; round < rounds; ++round) {
        for (std::uint32_t v = 0; v < grid.size(); ++v) {
            if (fixed_[v] != 0) continue;
            const Vec3f& n = units.frame(v).n;
            coefficients[v] = units.origin(v) + n * dot(n, gap(v));
        }
        const std::vector<Vec3> wanted = without_tangents(transform, coefficients);
        for (std::uint32_t v = 0; v < above.size(); ++v) steps[v] = wanted[v] - above[v] - drift.position(v);
        drift.move(steps);
        for (std::uint32_t v = 0; v < above.size(); ++v)
            if (fixed_[v] == 0) positions[v] = drift.position(v) + above[v];
        analyze(transform, positions, coefficients);
    }
    // Vertices on the surface are not those that come nearest to it.
    settle(surface_.mesh(), triangles_, fixed_, drift.normals(), {kFitRounds, true, threads}, positions);
    analyze(transform, positions, coefficients);
    // Vertices on lines, and those that have ended far from their grid points, take the nearest ones.
    for (std::uint32_t v = 0; v < grid.size(); ++v)
        if (fixed_[v] != 0 || length(to_double(gap(v))) > kMostCells * lattice.unit())
            grid[v] = lattice.nearest(to_double(coefficients[v]));
    take_vertex_data(surface_.mesh(), drift.points(), out.mesh);
    return out;
}

}  // namespace mvw
