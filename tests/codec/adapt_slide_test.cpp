#include "codec/enc_adapt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "codec/measure/surface_error.h"
#include "codec/remesh/remesh.h"
#include "tests/support/semi_regular_models.h"
#include "tests/support/shapes.h"

namespace mvw {
namespace {

/// A bumpy ball whose vertices have been pushed about within the surface.
SemiRegularMesh pushed_ball(unsigned levels) {
    SemiRegularMesh out = bumpy_ball(levels);
    for (Vec3& p : out.positions) {
        const Vec3 d = normalized(p);
        const Vec3 e = normalized(d + Vec3{std::sin(40 * d.y), std::sin(43 * d.z), std::sin(37 * d.x)} * 0.02);
        p = e * (1 + 0.2 * std::sin(5 * e.x) * std::cos(4 * e.y + 1) + 0.05 * std::sin(11 * e.z + 3 * e.x));
    }
    return out;
}

/// mesh after it has slid over `input`.
SemiRegularMesh slid(const Mesh& input, unsigned threads, SemiRegularMesh mesh) {
    PartSurface surface(input, threads);
    Adaptation adaptation(surface, {}, threads, std::move(mesh));
    adaptation.slide(threads);
    return adaptation.mesh();
}

double tangential_energy(const SemiRegularMesh& mesh) {
    std::vector<Vec3f> positions(mesh.positions.size()), details(mesh.positions.size());
    std::transform(mesh.positions.begin(), mesh.positions.end(), positions.begin(), to_float);
    PatchTransform(mesh.base, mesh.levels, {}, mesh.creases).analyze(positions, details);
    double sum = 0;
    for (std::size_t v = vertices_at_level(mesh.base, 2); v < details.size(); ++v) {
        const Vec3 d = to_double(details[v]);
        sum += d.y * d.y + d.z * d.z;
    }
    return sum;
}

TEST(Slide, TangentialDetailsFallAndTheSurfaceStays) {
    const Mesh input = plain(bumpy_ball(6));
    SemiRegularMesh mesh = pushed_ball(5);
    const double before = tangential_energy(mesh), error = surface_error(input, plain(mesh), {20'000, 1}).rms;
    mesh = slid(input, 1, std::move(mesh));
    EXPECT_LT(tangential_energy(mesh), before / 4);
    EXPECT_LT(surface_error(input, plain(mesh), {20'000, 1}).rms, 1.2 * error);
}

/// RMS distance of what a mesh shows with details up to `level` from `input`.
double error_of_level(const Mesh& input, const SemiRegularMesh& mesh, unsigned level) {
    std::vector<Vec3f> positions(mesh.positions.size()), details(mesh.positions.size());
    std::transform(mesh.positions.begin(), mesh.positions.end(), positions.begin(), to_float);
    PatchTransform transform(mesh.base, mesh.levels, {}, mesh.creases);
    transform.analyze(positions, details);
    std::fill(details.begin() + std::ptrdiff_t(vertices_at_level(mesh.base, level)), details.end(), Vec3f{});
    transform.synthesize(details, mesh.levels, positions);
    SemiRegularMesh shown = mesh;
    std::transform(positions.begin(), positions.end(), shown.positions.begin(), to_double);
    return surface_error(input, plain(shown), {20'000, 1}).rms;
}

TEST(Slide, WhatTheBaseShowsComesCloserToTheSurface) {
    Mesh input = icosphere(5);
    for (Vec3& p : input.positions) {  // ridges all around
        const double wave = std::sin(4 * p.x + 2 * p.y) * std::cos(3 * p.z);
        p = p * (1 + 0.15 * std::sqrt(wave * wave + 0.01));
    }
    RemeshOptions options;
    options.base_faces = 150;
    options.levels = 3;
    options.threads = 1;
    const SemiRegularMesh before = remesh(input, options).parts.at(0), after = slid(input, 1, before);
    EXPECT_LT(error_of_level(input, after, 0), 0.9 * error_of_level(input, before, 0));
}

TEST(Slide, VerticesOnCreasesStayOnThem) {
    SemiRegularMesh mesh = pushed_ball(4);
    mesh.creases.assign(mesh.base.edge_count(), 0);
    mesh.creases[2] = mesh.creases[5] = 1;
    const std::vector<std::uint8_t> on_line = line_vertices(mesh);
    const std::vector<Vec3> before = mesh.positions;
    mesh = slid(plain(bumpy_ball(6)), 1, std::move(mesh));
    std::size_t moved = 0;
    for (std::size_t v = 0; v < before.size(); ++v) {
        moved += length(mesh.positions[v] - before[v]) > 0;
        if (!on_line[v]) continue;
        double nearest = 1;  // distance from the line as it was
        for (std::size_t u = 0; u < before.size(); ++u)
            for (std::size_t w = 0; on_line[u] && w < before.size(); ++w) {
                const Vec3 along = before[w] - before[u];
                if (!on_line[w] || length(along) > 0.2 || u == w) continue;
                const double t =
                    std::clamp(dot(mesh.positions[v] - before[u], along) / squared_length(along), 0.0, 1.0);
                nearest = std::min(nearest, length(before[u] + along * t - mesh.positions[v]));
            }
        EXPECT_LT(nearest, 1e-9) << "vertex " << v;
    }
    EXPECT_GT(moved, before.size() / 2);
}

TEST(Slide, IsTheSameForAnyNumberOfThreads) {
    const Mesh input = plain(bumpy_ball(5));
    const SemiRegularMesh one = slid(input, 1, pushed_ball(4)), three = slid(input, 3, pushed_ball(4));
    for (std::size_t v = 0; v < one.positions.size(); ++v)
        EXPECT_EQ(length(one.positions[v] - three.positions[v]), 0) << "vertex " << v;
}

}  // namespace
}  // namespace mvw
