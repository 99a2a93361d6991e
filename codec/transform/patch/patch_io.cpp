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

}  // namespace

/// The lanes' runs of one level within a hierarchical array.
template <typename Float, typename Vec>
PatchTransform::State::Runs<Float> PatchTransform::State::face_runs(unsigned level, std::uint32_t g, Vec* array) const {
    Runs<Float> runs{};
    for (unsigned lane = 0; lane < used(g); ++lane)
        runs[lane] = &array[face_run(topology_.base(), level, g * lanes_ + lane)].x;
    return runs;
}

/// The same of side s; `others` where another patch owns it.
template <typename Float, typename Vec>
PatchTransform::State::Runs<Float> PatchTransform::State::side_runs(unsigned level, std::uint32_t g, unsigned s,
                                                                    Vec* array, Float* others) const {
    Runs<Float> runs{};
    for (unsigned lane = 0; lane < used(g); ++lane) {
        const std::uint32_t f = g * lanes_ + lane;
        runs[lane] =
            link(f, s).owned ? &array[edge_run(topology_.base(), level, topology_.base().edge_of(f, s))].x : others;
    }
    return runs;
}

/// Calls visit(base vertex, offset in the group) for each base vertex that a patch of group g owns.
template <typename Visit>
void PatchTransform::State::visit_corners(const LevelPlan& plan, std::uint32_t g, Visit visit) const {
    each_patch(g, [&](std::uint32_t f) {
        for (unsigned c = 0; c < 3; ++c) {
            const std::uint32_t corner = topology_.base().faces()[f][c];
            if (topology_.corner_owner(corner) == std::pair(f, c)) visit(corner, plan.side_points[c][0] + f % lanes_);
        }
    });
}

void PatchTransform::State::load_details(const LevelPlan& plan, std::uint32_t g, const Vec3f* from,
                                         Field& field) const {
    float* d = details_of(field, plan, g);
    const unsigned level = plan.level + 1;
    kernels().load_runs(plan.detail_places, face_runs<const float>(level, g, from).data(), used(g), true, d);
    for (unsigned s = 0; s < 3; ++s)
        kernels().load_runs(plan.side_detail_places[s],
                            side_runs<const float>(level, g, s, from, nothing_.data()).data(), used(g), false, d);
}

void PatchTransform::State::store_details(const LevelPlan& plan, std::uint32_t g, Field& field, Vec3f* to) {
    const float* d = details_of(field, plan, g);
    const unsigned level = plan.level + 1;
    kernels().store_runs(plan.detail_places, face_runs<float>(level, g, to).data(), used(g), true, d);
    for (unsigned s = 0; s < 3; ++s)
        kernels().store_runs(plan.side_detail_places[s], side_runs<float>(level, g, s, to, nowhere(g)).data(), used(g),
                             false, d);
}

void PatchTransform::State::load_vertices(const LevelPlan& plan, std::uint32_t g, const Vec3f* from, float* v) const {
    v += vertices_of(plan, g);
    for (unsigned j = 1; j <= plan.level; ++j) {
        kernels().load_runs(plan.vertex_places[j - 1], face_runs<const float>(j, g, from).data(), used(g), true, v);
        for (unsigned s = 0; s < 3; ++s)
            kernels().load_runs(plan.side_vertex_places[s][j - 1],
                                side_runs<const float>(j, g, s, from, nothing_.data()).data(), used(g), false, v);
    }
    visit_corners(plan, g, [&](std::uint32_t corner, std::uint32_t to) { copy_in(from[corner], v + to, lanes_); });
}

void PatchTransform::State::store_vertices(const LevelPlan& plan, std::uint32_t g, const float* v, Vec3f* to) {
    v += vertices_of(plan, g);
    for (unsigned j = 1; j <= plan.level; ++j) {
        kernels().store_runs(plan.vertex_places[j - 1], face_runs<float>(j, g, to).data(), used(g), true, v);
        for (unsigned s = 0; s < 3; ++s)
            kernels().store_runs(plan.side_vertex_places[s][j - 1], side_runs<float>(j, g, s, to, nowhere(g)).data(),
                                 used(g), false, v);
    }
    visit_corners(plan, g, [&](std::uint32_t corner, std::uint32_t from) { to[corner] = copy_out(v + from, lanes_); });
}

}  // namespace mvw
