#include "tests/support/shapes.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <random>
#include <utility>

namespace mvw {

Mesh mesh_of(std::vector<Vec3> positions, std::vector<Face> faces) {
    Mesh mesh;
    mesh.positions = std::move(positions);
    mesh.faces = std::move(faces);
    return mesh;
}

Mesh unit_square() {
    return mesh_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
}

Mesh unit_cube() {
    Mesh mesh;
    for (std::uint32_t v = 0; v < 8; ++v)
        mesh.positions.push_back({double(v & 1), double((v >> 1) & 1), double(v >> 2)});
    mesh.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                  {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

Mesh icosphere(unsigned levels) {
    const double g = std::numbers::phi;
    Mesh mesh;
    mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    mesh.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (unsigned level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
        const auto split = [&](std::uint32_t a, std::uint32_t b) {
            const auto [it, is_new] =
                middle.try_emplace({std::min(a, b), std::max(a, b)}, std::uint32_t(mesh.positions.size()));
            if (is_new) mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]) * 0.5);
            return it->second;
        };
        std::vector<Face> faces;
        for (const auto& [a, b, c] : mesh.faces) {
            const std::uint32_t ab = split(a, b), bc = split(b, c), ca = split(c, a);
            for (const Face& f : {Face{ab, bc, ca}, Face{a, ab, ca}, Face{b, bc, ab}, Face{c, ca, bc}})
                faces.push_back(f);
        }
        mesh.faces = std::move(faces);
    }
    for (Vec3& p : mesh.positions) p = normalized(p);
    return mesh;
}

Mesh torus(std::uint32_t around, std::uint32_t along) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t k = 0; k < along; ++k) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * k / along;
            const double r = 1 + 0.4 * std::cos(v);
            mesh.positions.push_back({r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)});
            const std::uint32_t a = i * along + k, b = (i + 1) % around * along + k;
            const std::uint32_t c = (i + 1) % around * along + (k + 1) % along, d = i * along + (k + 1) % along;
            mesh.faces.push_back({a, b, c});
            mesh.faces.push_back({a, c, d});
        }
    return mesh;
}

Mesh rough_torus(std::uint32_t around, std::uint32_t along, double noise) {
    Mesh mesh = torus(around, along);
    std::mt19937 random(7);
    for (Vec3& p : mesh.positions)
        for (double* x : {&p.x, &p.y, &p.z}) *x += 2 * noise * (double(random()) / double(std::mt19937::max()) - 0.5);
    return mesh;
}

Mesh chequered_plate(unsigned rings) {
    constexpr unsigned kCells = 5;  // of a field, the last of which is a wall
    const unsigned n = rings * kCells;
    const auto at = [n](unsigned x, unsigned y) { return y * (n + 1) + x; };
    Mesh mesh;
    for (const bool top : {true, false})
        for (unsigned y = 0; y <= n; ++y)
            for (unsigned x = 0; x <= n; ++x) {
                const bool wall_x = x % kCells == 0, wall_y = y % kCells == 0;
                const bool raised = !wall_x && !wall_y && (x / kCells + y / kCells) % 2 == 0;
                mesh.positions.push_back({double(x) / n, double(y) / n, top ? (raised ? 0.23 : 0.2) : 0.0});
            }
    const unsigned below = (n + 1) * (n + 1);
    for (unsigned y = 0; y < n; ++y)
        for (unsigned x = 0; x < n; ++x) {
            const unsigned a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
            mesh.faces.insert(
                mesh.faces.end(),
                {{a, b, c}, {a, c, d}, {below + a, below + c, below + b}, {below + a, below + d, below + c}});
        }
    const auto side = [&](unsigned a, unsigned b) {  // from a to b around the top, counter-clockwise
        mesh.faces.insert(mesh.faces.end(), {{a, below + a, below + b}, {a, below + b, b}});
    };
    for (unsigned k = 0; k < n; ++k) {
        side(at(k, 0), at(k + 1, 0));
        side(at(n, k), at(n, k + 1));
        side(at(n - k, n), at(n - k - 1, n));
        side(at(0, n - k), at(0, n - k - 1));
    }
    return mesh;
}

Mesh moved(Mesh mesh, const Vec3& by) {
    for (Vec3& p : mesh.positions) p += by;
    return mesh;
}

Mesh scaled(Mesh mesh, double factor) {
    for (Vec3& p : mesh.positions) p *= factor;
    return mesh;
}

}  // namespace mvw
