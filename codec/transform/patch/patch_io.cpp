// Between arrays in hierarchical order and groups of patches. Each patch moves its inner points, the sides and the
// corners that it owns.
#include "codec/transform/patch/patch_state.h"

namespace mvw {

namespace {

/// Where a face's run of the points born on level `level` starts: behind that level's edges.
std::size_t face_run(const BaseMesh& base, unsigned level, std::uint32_t f) {
    const std::uint64_t run = interior_points(level) - interior_points(level - 1);
    return static_cast<std::size_t>(vertices_at_level(base, level - 1) +
                                    (std::uint64_t{base.edge_count()} << (level - 1)) + f * run);
}
/// Where a base edge's run of points born on that level starts.
std::size_t edge_run(const BaseMesh& base, unsigned level, std::uint32_t e) {
    return static_cast<std::size_t>(vertices_at_level(base, level - 1) + (std::uint64_t{e} << (level - 1)));
}

void copy_in(const Vec3f& from, float* to, unsigned lanes) {
    to[0] = from.x;
    to[lanes] = from.y;
    to[2 * lanes] = from.z;
}
Vec3f copy_out(const float* from, unsigned lanes) {
    return {from[0], from[lanes], from[2 * lanes]};
}

/// The lanes' runs of one level within a hierarchical array.
template <typename Float, typename Vec>
std::array<Float*, 16> runs_of(const GridTopology& topology, unsigned level, std::uint32_t first_face, unsigned used,
                               Vec* array) {
    std::array<Float*, 16> runs{};
    for (unsigned lane = 0; lane < used; ++lane)
        runs[lane] = &array[face_run(topology.base(), level, first_face + lane)].x;
    return runs;
}

}  // namespace

/// Calls visit(hierarchical index, offset in the group) for each vertex of the level that lies on a side or corner
/// which a patch of group g owns.
template <typename Visit>
void PatchTransform::State::visit_sides(const LevelPlan& plan, std::uint32_t g, Visit visit) const {
    const BaseMesh& base = topology_.base();
    for (unsigned lane = 0; lane < used(g); ++lane) {
        const std::uint32_t f = g * lanes_ + lane;
        for (unsigned s = 0; s < 3; ++s) {
            const std::vector<std::uint32_t>& points = plan.side_points[s];
            const std::uint32_t corner = base.faces()[f][s];
            if (topology_.corner_owner(corner) == std::pair(f, s)) visit(corner, points[0] + lane);
            if (!topology_.owns_side(f, s)) continue;
            for (unsigned j = 1; j <= plan.level; ++j) {
                std::size_t at = edge_run(base, j, base.edge_of(f, s));
                const std::size_t step = std::size_t{1} << (plan.level - j);
                for (std::size_t t = step; t < points.size(); t += 2 * step) visit(at++, points[t] + lane);
            }
        }
    }
}

void PatchTransform::State::load_details(const LevelPlan& plan, std::uint32_t g, const Vec3f* from,
                                         Field& field) const {
    float* d = details_of(field, plan, g);
    const auto runs = runs_of<const float>(topology_, plan.level + 1, g * lanes_, used(g), from);
    kernels().load_runs(plan.detail_places, runs.data(), used(g), d);
    each_patch(g, [&](std::uint32_t f) {
        for (unsigned s = 0; s < 3; ++s) {
            const std::vector<std::uint32_t>& places = plan.side_edges[s];
            float* to = d + f % lanes_;
            if (link(f, s).owned)
                kernels().load_points(
                    places, from + edge_run(topology_.base(), plan.level + 1, topology_.base().edge_of(f, s)), to);
            else
                kernels().clear_points(places, to);
        }
    });
}

void PatchTransform::State::store_details(const LevelPlan& plan, std::uint32_t g, Field& field, Vec3f* to) const {
    const float* d = details_of(field, plan, g);
    const auto runs = runs_of<float>(topology_, plan.level + 1, g * lanes_, used(g), to);
    kernels().store_runs(plan.detail_places, runs.data(), used(g), d);
    each_patch(g, [&](std::uint32_t f) {
        for (unsigned s = 0; s < 3; ++s)
            if (link(f, s).owned)
                kernels().store_points(plan.side_edges[s], d + f % lanes_,
                                       to + edge_run(topology_.base(), plan.level + 1, topology_.base().edge_of(f, s)));
    });
}

void PatchTransform::State::load_vertices(const LevelPlan& plan, std::uint32_t g, const Vec3f* from, float* v) const {
    v += vertices_of(plan, g);
    for (unsigned j = 1; j <= plan.level; ++j) {
        const auto runs = runs_of<const float>(topology_, j, g * lanes_, used(g), from);
        kernels().load_runs(plan.vertex_places[j - 1], runs.data(), used(g), v);
    }
    visit_sides(plan, g, [&](std::size_t at, std::uint32_t to) { copy_in(from[at], v + to, lanes_); });
}

void PatchTransform::State::store_vertices(const LevelPlan& plan, std::uint32_t g, const float* v, Vec3f* to) const {
    v += vertices_of(plan, g);
    for (unsigned j = 1; j <= plan.level; ++j) {
        const auto runs = runs_of<float>(topology_, j, g * lanes_, used(g), to);
        kernels().store_runs(plan.vertex_places[j - 1], runs.data(), used(g), v);
    }
    visit_sides(plan, g, [&](std::size_t at, std::uint32_t from) { to[at] = copy_out(v + from, lanes_); });
}

}  // namespace mvw
