#include "codec/transform/patch/layout.h"

#include <algorithm>

namespace mvw {

Layout::Layout(unsigned level, unsigned lane_count) : n(1 << level), lanes(lane_count) {
    const auto step = static_cast<std::int32_t>(stride());
    row_starts_.resize(static_cast<std::size_t>(n) + 3);
    std::int32_t end = 0;
    // Rows 0 and -1 have no ghosts at their ends: the rows around them are what kernels read there, and discard.
    const auto place = [&](int i, int first, int count) {
        row_starts_[static_cast<std::size_t>(i) + 1] = end - first * step;
        end += count * step;
    };
    place(1, -1, n + 2);
    place(0, 0, n + 1);
    place(-1, 1, n);
    for (int i = 2; i <= n; ++i) place(i, -1, n + 3 - i);
    if (n == 1) end += step;  // behind row -1, where there is no row 2
    row_starts_.back() = static_cast<std::int32_t>(row(n));
    vertex_floats = static_cast<std::uint32_t>(end);
    edge_floats = static_cast<std::uint32_t>(3 * n * (n + 1) / 2) * stride();
}

GridTopology::GridTopology(const BaseMesh& base) : base_(base), corner_owner_(base.vertex_count(), {kNone, 0}) {
    for (std::uint32_t f = 0; f < base_.face_count(); ++f)
        for (unsigned c = 0; c < 3; ++c)
            if (auto& owner = corner_owner_[base_.faces()[f][c]]; owner.first == kNone) owner = {f, c};
}

std::uint32_t GridTopology::neighbour(std::uint32_t f, unsigned s) const {
    return base_.edges()[base_.edge_of(f, s)].face[owns_side(f, s) ? 1 : 0];
}

unsigned GridTopology::neighbour_side(std::uint32_t f, unsigned s) const {
    return base_.edges()[base_.edge_of(f, s)].side[owns_side(f, s) ? 1 : 0];
}

GridVertex GridTopology::corner(std::uint32_t f, unsigned corner, int n) const {
    return {f, corner == 1 ? n : 0, corner == 2 ? n : 0};
}

std::array<Barycentric, 2> edge_ends(EdgePlane plane, int i, int k, int n) {
    switch (plane) {
        case kH:
            return {barycentric(i, k, n), barycentric(i + 1, k, n)};
        case kV:
            return {barycentric(i, k + 1, n), barycentric(i, k, n)};
        case kD:
            break;
    }
    return {barycentric(i + 1, k, n), barycentric(i, k + 1, n)};
}

GridEdge edge_between(std::uint32_t face, const Barycentric& a, const Barycentric& b) {
    const EdgePlane plane = a[2] == b[2] ? kH : a[1] == b[1] ? kV : kD;
    return {face, plane, std::min(a[1], b[1]), std::min(a[2], b[2])};
}

GridVertex GridTopology::owner(GridVertex v, int n) const {
    Barycentric b = barycentric(v.i, v.k, n);
    std::uint32_t f = v.face;
    for (unsigned s = 0; s < 3;) {
        // Cross the side whose far corner has a negative weight; then look again from the new face.
        if (b[(s + 2) % 3] >= 0) {
            ++s;
            continue;
        }
        const std::uint32_t g = neighbour(f, s);
        if (g == kNone) return {kNone, 0, 0};
        const unsigned t = neighbour_side(f, s);
        b = across(b, s, t);
        f = g;
        s = 0;
    }
    for (unsigned c = 0; c < 3; ++c)
        if (b[c] == n) {
            const auto [face, at] = corner_owner_[base_.faces()[f][c]];
            return corner(face, at, n);
        }
    for (unsigned s = 0; s < 3; ++s)
        if (b[(s + 2) % 3] == 0 && !owns_side(f, s)) {
            const std::uint32_t g = neighbour(f, s);
            const Barycentric c = across(b, s, neighbour_side(f, s));
            return {g, c[1], c[2]};
        }
    return {f, b[1], b[2]};
}

GridEdge GridTopology::owner(GridEdge e, int n) const {
    auto [a, b] = edge_ends(e.plane, e.i, e.k, n);
    std::uint32_t f = e.face;
    for (unsigned s = 0; s < 3;) {
        const int za = a[(s + 2) % 3], zb = b[(s + 2) % 3];
        if (za > 0 || zb > 0 || (za == 0 && zb == 0 && owns_side(f, s))) {
            ++s;
            continue;
        }
        const std::uint32_t g = neighbour(f, s);
        if (g == kNone) return {kNone, kH, 0, 0};
        const unsigned t = neighbour_side(f, s);
        a = across(a, s, t);
        b = across(b, s, t);
        f = g;
        s = 0;
    }
    return edge_between(f, a, b);
}

}  // namespace mvw
