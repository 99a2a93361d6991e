// Small base meshes that the transform tests share, with geometry that no transform predicts.
#pragma once
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "codec/mesh/semi_regular.h"

namespace mvw::test {

struct NamedBase {
    std::string name;
    BaseMesh base;
    std::vector<std::uint8_t> creases;
};

inline BaseMesh make_base(std::uint32_t vertices, std::vector<Face> faces) {
    return BaseMesh::create(vertices, std::move(faces)).value();
}

inline BaseMesh tetrahedron() {
    return make_base(4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
}
inline BaseMesh octahedron() {
    return make_base(6, {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
}
inline BaseMesh one_triangle() {
    return make_base(3, {{0, 1, 2}});
}
inline BaseMesh two_triangle_square() {
    return make_base(4, {{0, 1, 2}, {0, 2, 3}});
}
/// Moebius' torus: 7 vertices of valence 6, every two of them joined.
inline BaseMesh seven_vertex_torus() {
    std::vector<Face> faces;
    for (std::uint32_t i = 0; i < 7; ++i) {
        faces.push_back({i, (i + 1) % 7, (i + 3) % 7});
        faces.push_back({i, (i + 3) % 7, (i + 2) % 7});
    }
    return make_base(7, std::move(faces));
}
/// n triangles around vertex 0.
inline BaseMesh fan(std::uint32_t n) {
    std::vector<Face> faces;
    for (std::uint32_t i = 0; i < n; ++i) faces.push_back({0, 1 + i, 1 + (i + 1) % n});
    return make_base(n + 1, std::move(faces));
}
/// Two apexes over a ring of n: valences n and 4, closed.
inline BaseMesh bipyramid(std::uint32_t n) {
    std::vector<Face> faces;
    for (std::uint32_t i = 0; i < n; ++i) {
        faces.push_back({n, i, (i + 1) % n});
        faces.push_back({n + 1, (i + 1) % n, i});
    }
    return make_base(n + 2, std::move(faces));
}
/// A quad grid of w x h cells, each cut in two; with `torus`, opposite sides joined (w, h >= 4). Cells in `holes`
/// are left out.
inline BaseMesh grid(std::uint32_t w, std::uint32_t h, bool torus, const std::vector<std::uint32_t>& holes = {}) {
    const std::uint32_t row = torus ? w : w + 1;
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return torus ? (y % h) * row + x % w : y * row + x; };
    std::vector<Face> faces;
    for (std::uint32_t y = 0; y < h; ++y)
        for (std::uint32_t x = 0; x < w; ++x) {
            if (std::find(holes.begin(), holes.end(), y * w + x) != holes.end()) continue;
            faces.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
            faces.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    return make_base(torus ? w * h : row * (h + 1), std::move(faces));
}

/// `count` tori in a row, each joined with the next where both lose a triangle: closed, of genus `count`.
inline BaseMesh chain_of_tori(std::uint32_t count) {
    const BaseMesh torus = grid(4, 5, true);
    const std::uint32_t V = torus.vertex_count(), F = torus.face_count();
    std::vector<std::uint32_t> names(std::size_t{count} * V);
    for (std::uint32_t v = 0; v < names.size(); ++v) names[v] = v;
    std::vector<Face> faces;
    for (std::uint32_t t = 0; t < count; ++t) {
        const Face& first = torus.faces()[0];
        const Face& last = torus.faces()[F - 11];
        // This torus' first triangle lies on the last one of the torus before, turned over.
        for (unsigned c = 0; c < 3 && t > 0; ++c) names[t * V + first[c]] = names[(t - 1) * V + last[(3 - c) % 3]];
        for (std::uint32_t f = 0; f < F; ++f) {
            if ((f == 0 && t > 0) || (f == F - 11 && t + 1 < count)) continue;
            const Face& face = torus.faces()[f];
            faces.push_back({names[t * V + face[0]], names[t * V + face[1]], names[t * V + face[2]]});
        }
    }
    // Without gaps in the numbers.
    std::vector<std::uint32_t> dense(names.size(), kNone);
    std::uint32_t used = 0;
    for (Face& f : faces)
        for (std::uint32_t& v : f) {
            if (dense[v] == kNone) dense[v] = used++;
            v = dense[v];
        }
    return make_base(used, std::move(faces));
}

/// All of them: closed, open, genus 1 to 3, valences 3 to 12, creases that pass, end and meet.
inline std::vector<NamedBase> all_bases() {
    std::vector<NamedBase> bases;
    const auto add = [&](std::string name, BaseMesh base, const std::vector<std::uint32_t>& creases = {}) {
        std::vector<std::uint8_t> flags;
        if (!creases.empty()) flags.resize(base.edge_count());
        for (const std::uint32_t e : creases) flags[e] = 1;
        bases.push_back({std::move(name), std::move(base), std::move(flags)});
    };
    add("tetrahedron", tetrahedron());
    add("octahedron", octahedron());
    add("one triangle", one_triangle());
    add("square", two_triangle_square());
    add("7-vertex torus", seven_vertex_torus());
    for (const std::uint32_t n : {3u, 4u, 5u, 6u, 7u, 9u, 12u}) add("fan " + std::to_string(n), fan(n));
    for (const std::uint32_t n : {3u, 5u, 8u, 12u}) add("bipyramid " + std::to_string(n), bipyramid(n));
    add("torus 4x5", grid(4, 5, true));
    add("genus 2", chain_of_tori(2));
    add("genus 3", chain_of_tori(3));
    add("torus 5x5 with holes", grid(5, 5, true, {6, 13}));
    add("sheet 3x4", grid(3, 4, false));
    add("sheet with hole", grid(4, 4, false, {5, 6}));
    add("creased octahedron", octahedron(), {0, 1, 4});
    add("creased square", two_triangle_square(), {2});
    add("creased torus", grid(4, 5, true), {0, 3, 7, 8, 9, 20});
    return bases;
}

/// Positions for `count` vertices without structure, in a box of about unit size.
inline std::vector<Vec3> random_positions(std::size_t count, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::vector<Vec3> positions(count);
    const auto unit = [&] { return double(random()) / 4294967296.0 - 0.5; };
    for (Vec3& p : positions) {
        p.x = unit();
        p.y = unit();
        p.z = unit();
    }
    return positions;
}

inline double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, length(a[i] - b[i]));
    return worst;
}

}  // namespace mvw::test
