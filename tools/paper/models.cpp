#include "tools/paper/models.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "codec/mesh/io/mesh_io.h"
#include "codec/mesh/refine.h"
#include "codec/remesh/remesh.h"

namespace mvw::paper {
namespace {

/// Into units of the diagonal, around the origin.
Model finished(std::string name, std::string origin, SemiRegularMesh mesh) {
    Box box;
    for (const Vec3& p : mesh.positions) box.add(p);
    for (Vec3& p : mesh.positions) p = (p - box.center()) / box.diagonal();
    return {std::move(name), std::move(origin), std::move(mesh)};
}

Result<Model> from_file(const std::string& folder, const std::string& name, unsigned faces, bool z_up,
                        unsigned levels) {
    CleanReport report;
    auto mesh = read_mesh(folder + "/" + name + ".ply", report);
    if (!mesh.ok()) return mesh.error();
    for (Vec3& p : mesh->positions)
        if (z_up) p = {p.x, p.z, -p.y};
    RemeshOptions options;
    options.base_faces = faces;
    options.levels = static_cast<int>(levels);
    RemeshResult remeshed = remesh(*mesh, options);
    const auto largest =
        std::max_element(remeshed.parts.begin(), remeshed.parts.end(),
                         [](const auto& a, const auto& b) { return a.positions.size() < b.positions.size(); });
    if (largest == remeshed.parts.end() || largest->levels != levels)
        return Error{Errc::Unsupported, 0, name + " could not be remeshed to " + std::to_string(levels) + " levels"};
    const std::uint32_t got = largest->base.face_count();
    std::string origin =
        fmt::format("{}.ply, {} faces, resampled over {} base faces by our remesher", name, mesh->faces.size(), got);
    if (got != faces) origin += fmt::format(" ({} were asked for)", faces);
    return finished(name, std::move(origin), std::move(*largest));
}

/// The surface of math.md's noise experiment over an icosahedron cut twice: 320 base faces.
Model ball(unsigned levels) {
    const double g = std::numbers::phi;
    const std::vector<Vec3> corners{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    const std::vector<Face> faces{{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    const SemiRegularMesh cut =
        refine(BaseMesh::create(12, faces).value(), corners, 2, [](const Vec3& p) { return normalized(p); });
    BaseMesh base =
        BaseMesh::create(static_cast<std::uint32_t>(cut.positions.size()), triangles_at_level(cut.base, 2)).value();
    return finished("ball", "a bumpy ball by formula over an icosahedron cut twice",
                    refine(std::move(base), cut.positions, levels, [](const Vec3& p) {
                        const Vec3 d = normalized(p);
                        return d *
                               (1 + 0.2 * std::sin(5 * d.x) * std::cos(4 * d.y + 1) +
                                0.08 * std::sin(11 * d.z + 3 * d.x) + 0.02 * std::sin(31 * d.y) * std::sin(29 * d.z));
                    }));
}

/// A grid of w x h quads in two triangles each, laid out by `place` of its parameters in [0, 1]; closed: a torus.
template <typename Place>
SemiRegularMesh sheet(std::uint32_t w, std::uint32_t h, bool closed, unsigned levels, Place place) {
    const std::uint32_t columns = closed ? w : w + 1, rows = closed ? h : h + 1;
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return (y % rows) * columns + x % columns; };
    std::vector<Face> faces;
    for (std::uint32_t y = 0; y < h; ++y)
        for (std::uint32_t x = 0; x < w; ++x) {
            faces.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
            faces.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    BaseMesh base = BaseMesh::create(columns * rows, faces).value();
    SemiRegularMesh mesh;
    mesh.levels = levels;
    mesh.positions.resize(vertices_at_level(base, levels));
    std::vector<std::uint32_t> patch;
    const unsigned n = 1u << levels;
    for (std::uint32_t f = 0; f < base.face_count(); ++f) {
        patch_vertices(base, f, levels, patch);
        const std::uint32_t square = f / 2, x = square % w, y = square / w;
        std::size_t p = 0;
        for (unsigned i = 0; i <= n; ++i)
            for (unsigned k = 0; i + k <= n; ++k) {
                const double u = f % 2 == 0 ? double(i) / n : 1 - double(k) / n, v = double(f % 2 == 0 ? k : i + k) / n;
                mesh.positions[patch[p++]] = place((x + u) / w, (y + v) / h);
            }
    }
    mesh.base = std::move(base);
    return mesh;
}

Model ring(unsigned levels) {
    constexpr double turn = 2 * std::numbers::pi;
    return finished("ring", "a bumpy torus by formula", sheet(18, 14, true, levels, [](double a, double b) {
                        const double r = 1 + 0.1 * std::sin(3 * turn * a) * std::cos(2 * turn * b) +
                                         0.03 * std::sin(11 * turn * a + 5 * turn * b);
                        const double out = 3 + r * std::cos(turn * b);
                        return Vec3{out * std::cos(turn * a), out * std::sin(turn * a), r * std::sin(turn * b)};
                    }));
}

Model wave(unsigned levels) {
    return finished(
        "wave", "an open sheet of waves by formula", sheet(11, 10, false, levels, [](double x, double y) {
            return Vec3{x * 2, y * 2, 0.2 * std::sin(7 * x) * std::cos(5 * y) + 0.03 * std::sin(29 * x * y + 11 * y)};
        }));
}

Model knob(unsigned levels) {
    constexpr double turn = 2 * std::numbers::pi;
    return finished("knob", "a fluted torus by formula", sheet(12, 8, true, levels, [](double a, double b) {
                        const double r = 1 + 0.15 * std::pow(std::cos(4 * turn * a), 3);
                        const double out = 2 + r * std::cos(turn * b);
                        return Vec3{out * std::sin(turn * a), r * std::sin(turn * b), out * std::cos(turn * a)};
                    }));
}

}  // namespace

std::vector<Vec3f> Model::positions() const {
    std::vector<Vec3f> out(mesh.positions.size());
    std::transform(mesh.positions.begin(), mesh.positions.end(), out.begin(), to_float);
    return out;
}

Mesh Model::surface(unsigned level, std::span<const Vec3f> positions) const {
    Mesh out;
    for (const Vec3f& p : positions.first(vertices_at_level(mesh.base, level))) out.positions.push_back(to_double(p));
    out.faces = triangles_at_level(mesh.base, level);
    return out;
}

Result<std::vector<Model>> load_models(const std::string& folder, unsigned levels) {
    std::vector<Model> models;
    if (folder.empty()) {
        models.push_back(wave(levels));
        models.push_back(ball(levels));
        models.push_back(ring(levels));
        models.push_back(knob(levels));
        return models;
    }
    struct Wanted {
        const char* name;
        unsigned faces;  // of the first three: the paper's horse, venus and feline are 5 levels over as many
        bool z_up = false;
    };
    for (const Wanted& w :
         {Wanted{"lucy", 220, true}, Wanted{"koala", 388}, Wanted{"skull", 504}, Wanted{"sr_bunny_oct7", 300}}) {
        Result<Model> model = from_file(folder, w.name, w.faces, w.z_up, levels);
        if (!model.ok()) return model.error();
        models.push_back(std::move(*model));
    }
    return models;
}

}  // namespace mvw::paper
