#include "tests/support/meshes.h"

#include <cmath>
#include <numbers>

namespace mvw {
namespace {

void add_quad(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.faces.push_back({a, b, c});
    mesh.faces.push_back({a, c, d});
}

}  // namespace

Mesh tetrahedron_mesh() {
    return {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}, {}, {}};
}

Mesh grid_mesh(unsigned n) {
    Mesh mesh;
    for (unsigned y = 0; y <= n; ++y)
        for (unsigned x = 0; x <= n; ++x) {
            mesh.positions.push_back({static_cast<double>(x) / n, static_cast<double>(y) / n, 0});
            const unsigned at = y * (n + 1) + x;
            if (x < n && y < n) add_quad(mesh, at, at + 1, at + n + 2, at + n + 1);
        }
    return mesh;
}

Mesh moebius_mesh(unsigned n) {
    Mesh mesh;
    for (unsigned i = 0; i < n; ++i) {
        const double a = 2 * std::numbers::pi * i / n;
        for (const double side : {-0.5, 0.5}) {
            const double r = 2 + side * std::cos(a / 2);
            mesh.positions.push_back({r * std::cos(a), r * std::sin(a), side * std::sin(a / 2)});
        }
        const bool last = i + 1 == n;  // the strip closes after half a turn
        const unsigned low = last ? 1 : 2 * i + 2, high = last ? 0 : 2 * i + 3;
        add_quad(mesh, 2 * i, low, high, 2 * i + 1);
    }
    return mesh;
}

Mesh join(Mesh a, const Mesh& b) {
    const auto shift = static_cast<std::uint32_t>(a.positions.size());
    a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
    a.colors.insert(a.colors.end(), b.colors.begin(), b.colors.end());
    a.materials.insert(a.materials.end(), b.materials.begin(), b.materials.end());
    for (const Face& f : b.faces) a.faces.push_back({f[0] + shift, f[1] + shift, f[2] + shift});
    return a;
}

Mesh without_sharing(const Mesh& mesh) {
    Mesh out;
    out.materials = mesh.materials;
    for (const Face& f : mesh.faces) {
        const auto first = static_cast<std::uint32_t>(out.positions.size());
        out.faces.push_back({first, first + 1, first + 2});
        for (const std::uint32_t v : f) {
            out.positions.push_back(mesh.positions[v]);
            if (!mesh.colors.empty()) out.colors.push_back(mesh.colors[v]);
        }
    }
    return out;
}

}  // namespace mvw
