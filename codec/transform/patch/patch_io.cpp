// Between arrays in hierarchical order and the planes of patches. Each patch moves its inner points, the sides and the
// corners that it owns.
#include "codec/transform/patch/patch_state.h"

namespace mvw {

/// Calls visit(hierarchical index, offset in a plane) for each vertex of the level that patch f owns.
template <typename Visit>
void PatchTransform::State::visit_vertices(const LevelPlan& plan, std::uint32_t f, Visit visit) const {
    const BaseMesh& base = topology_.base();
    const Layout& layout = plan.layout;
    for (unsigned c = 0; c < 3; ++c)
        if (topology_.corner_owner(base.faces()[f][c]) == std::pair(f, c)) {
            const GridVertex v = topology_.corner(f, c, layout.n);
            visit(base.faces()[f][c], layout.at(v.i, v.k));
        }
    for (unsigned j = 1; j <= plan.level; ++j) {
        const int n = 1 << j, step = layout.n / n;
        const std::uint64_t start = vertices_at_level(base, j - 1);
        for (unsigned s = 0; s < 3; ++s) {
            if (!topology_.owns_side(f, s)) continue;
            std::uint64_t at = start + std::uint64_t{base.edge_of(f, s)} * static_cast<unsigned>(n / 2);
            for (int t = 1; t < n; t += 2, ++at) {
                const int along = t * step, back = layout.n - along;
                visit(at, s == 0 ? layout.at(along, 0) : s == 1 ? layout.at(back, along) : layout.at(0, back));
            }
        }
        std::uint64_t at = start + std::uint64_t{base.edge_count()} * static_cast<unsigned>(n / 2) +
                           f * (interior_points(j) - interior_points(j - 1));
        for (int i = 1; i < n; ++i) {
            const std::ptrdiff_t row = layout.row(i * step);
            const int stride = i % 2 == 1 ? 1 : 2;
            for (int k = 1; k < n - i; k += stride) visit(at++, static_cast<std::uint32_t>(row + k * step));
        }
    }
}

/// Calls visit(place in the level's edge runs, offset of the detail) for the sides that patch f owns.
template <typename Visit>
void PatchTransform::State::visit_side_details(const LevelPlan& plan, std::uint32_t f, Visit visit) const {
    const BaseMesh& base = topology_.base();
    const Layout& layout = plan.layout;
    const int n = layout.n;
    for (unsigned s = 0; s < 3; ++s) {
        if (!topology_.owns_side(f, s)) continue;
        std::size_t at = std::size_t{base.edge_of(f, s)} * static_cast<unsigned>(n);
        for (int t = 0; t < n; ++t, ++at)
            visit(at, s == 0   ? kH * layout.plane + layout.at(t, 0)
                      : s == 1 ? kD * layout.plane + layout.at(n - 1 - t, t)
                               : kV * layout.plane + layout.at(0, n - 1 - t));
    }
}

namespace {

/// Where a face's run of new interior points of the next level starts.
std::size_t face_run(const BaseMesh& base, unsigned level, std::uint32_t f) {
    const std::uint64_t run = interior_points(level + 1) - interior_points(level);
    return static_cast<std::size_t>(vertices_at_level(base, level) + (std::uint64_t{base.edge_count()} << level) +
                                    f * run);
}

}  // namespace

void PatchTransform::State::load_details(const LevelPlan& plan, std::uint32_t f, const Vec3f* from) {
    const std::size_t stride = std::size_t{3} * plan.layout.plane;
    float* d = details_.data() + 3 * stride * f;
    kernels().load_details(plan.layout, from + face_run(topology_.base(), plan.level, f), d);
    const Vec3f* sides = from + vertices_at_level(topology_.base(), plan.level);
    visit_side_details(plan, f, [&](std::size_t at, std::uint32_t to) {
        for (std::size_t c = 0; c < 3; ++c) d[to + c * stride] = sides[at][c];
    });
}

void PatchTransform::State::store_details(const LevelPlan& plan, std::uint32_t f, Vec3f* to) const {
    const std::size_t stride = std::size_t{3} * plan.layout.plane;
    const float* d = details_.data() + 3 * stride * f;
    kernels().store_details(plan.layout, d, to + face_run(topology_.base(), plan.level, f));
    Vec3f* sides = to + vertices_at_level(topology_.base(), plan.level);
    visit_side_details(plan, f, [&](std::size_t at, std::uint32_t from) {
        for (std::size_t c = 0; c < 3; ++c) sides[at][c] = d[from + c * stride];
    });
}

void PatchTransform::State::load_vertices(const LevelPlan& plan, std::uint32_t f, const Vec3f* from) {
    const std::size_t plane = plan.layout.plane;
    float* v = vertices(plan.level) + 3 * plane * f;
    visit_vertices(plan, f, [&](std::uint64_t at, std::uint32_t to) {
        for (std::size_t c = 0; c < 3; ++c) v[to + c * plane] = from[at][c];
    });
}

void PatchTransform::State::store_vertices(const LevelPlan& plan, std::uint32_t f, Vec3f* to) const {
    const std::size_t plane = plan.layout.plane;
    const float* v = vertices(plan.level) + 3 * plane * f;
    visit_vertices(plan, f, [&](std::uint64_t at, std::uint32_t from) {
        for (std::size_t c = 0; c < 3; ++c) to[at][c] = v[from + c * plane];
    });
}

}  // namespace mvw
