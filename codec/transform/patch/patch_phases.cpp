#include "codec/transform/patch/patch_state.h"

namespace mvw {

namespace {

Vec3f get(const float* planes, std::size_t at, std::size_t stride) {
    return {planes[at], planes[at + stride], planes[at + 2 * stride]};
}
void put(float* planes, std::size_t at, std::size_t stride, const Vec3f& value) {
    planes[at] = value.x;
    planes[at + stride] = value.y;
    planes[at + 2 * stride] = value.z;
}

/// Copies by offset within all three components.
void copy3(std::span<const Copy> copies, const float* from, float* to, std::size_t stride) {
    for (const Copy& c : copies) {
        to[c.to] = from[c.from];
        to[c.to + stride] = from[c.from + stride];
        to[c.to + 2 * stride] = from[c.from + 2 * stride];
    }
}
std::span<const Copy> run(const std::vector<Copy>& copies, const PatchRuns& first, std::uint32_t f) {
    return std::span(copies).subspan(first[f], first[f + 1] - first[f]);
}

/// Offset of the t-th point of side s.
std::uint32_t side_point(const Layout& layout, unsigned s, int t) {
    const int n = layout.n;
    return s == 0 ? layout.at(t, 0) : s == 1 ? layout.at(n - t, t) : layout.at(0, n - t);
}
/// Offset, within one component, of the detail between points t and t + 1 of side s.
std::uint32_t side_detail(const Layout& layout, unsigned s, int t) {
    const int n = layout.n;
    return s == 0   ? layout.at(t, 0)
           : s == 1 ? kD * layout.plane + layout.at(n - 1 - t, t)
                    : kV * layout.plane + layout.at(0, n - 1 - t);
}

}  // namespace

void PatchTransform::State::sync_vertices(const LevelPlan& plan, std::uint32_t f, float* planes) const {
    const std::size_t plane = plan.layout.plane;
    float* own = planes + 3 * plane * f;
    for (unsigned s = 0; s < 3; ++s) {
        const std::uint32_t g = topology_.neighbour(f, s);
        if (g == kNone) continue;
        const auto& copies = plan.vertex_copies[s][topology_.neighbour_side(f, s)][topology_.owns_side(f, s) ? 1 : 0];
        copy3(copies, planes + 3 * plane * g, own, plane);
    }
    copy3(run(plan.vertex_fixes, plan.first_vertex_fix, f), planes, planes, plane);
}

void PatchTransform::State::fold_boundary(const LevelPlan& plan, std::uint32_t f, float* v) const {
    const std::size_t plane = plan.layout.plane;
    float* own = v + 3 * plane * f;
    for (unsigned s = 0; s < 3; ++s)
        if (topology_.neighbour(f, s) == kNone) copy3(plan.folded_vertices[s], own, own, plane);
}

void PatchTransform::State::sync_edges(const LevelPlan& plan, std::uint32_t f) {
    const std::size_t plane = plan.layout.plane;
    float* d = details_.data();
    for (unsigned s = 0; s < 3; ++s) {
        const std::uint32_t g = topology_.neighbour(f, s);
        if (g == kNone) continue;
        const auto& copies = plan.edge_copies[s][topology_.neighbour_side(f, s)][topology_.owns_side(f, s) ? 1 : 0];
        copy3(copies, d + 9 * plane * g, d + 9 * plane * f, 3 * plane);
    }
    copy3(run(plan.edge_fixes, plan.first_edge_fix, f), d, d, 3 * plane);
}

void PatchTransform::State::zero_ghosts(const LevelPlan& plan, std::uint32_t f) {
    const std::size_t stride = 3 * plan.layout.plane;
    float* own = details_.data() + 3 * stride * f;
    for (const std::uint32_t at : plan.zero_at_corners) put(own, at, stride, {});
    for (unsigned s = 0; s < 3; ++s)
        if (topology_.neighbour(f, s) == kNone)
            for (const std::uint32_t at : plan.zero_beyond[s]) put(own, at, stride, {});
    if (f == 0) put(details_.data(), plan.zero_slot(faces()), stride, {});
}

void PatchTransform::State::corner_normals(const LevelPlan& plan, std::uint32_t begin, std::uint32_t end) {
    const std::size_t plane = plan.layout.plane;
    const float* v = vertices(plan.level);
    for (std::uint32_t b = begin; b < end; ++b) {
        const Corner& corner = plan.corners[b];
        if (corner.vertex == kNone) continue;
        const Vec3f p = get(v, corner.vertex, plane);
        Vec3f sum;
        for (std::uint32_t t = b == 0 ? 0 : plan.corners[b - 1].last_triangle; t < corner.last_triangle; ++t)
            sum +=
                cross(get(v, plan.corner_triangles[t][0], plane) - p, get(v, plan.corner_triangles[t][1], plane) - p);
        corner_normals_[b] = normalized(sum);
    }
}

void PatchTransform::State::corner_shapes(const LevelPlan& plan, std::uint32_t begin, std::uint32_t end) {
    const std::size_t plane = plan.layout.plane;
    const float* v = vertices(plan.level);
    for (std::uint32_t b = begin; b < end; ++b) {
        const Corner& corner = plan.corners[b];
        const std::uint32_t first = b == 0 ? 0 : plan.corners[b - 1].last_neighbour;
        corner_shapes_[b] = {};
        if (corner.vertex == kNone || first == corner.last_neighbour) continue;
        Vec3f mean;
        for (std::uint32_t i = first; i < corner.last_neighbour; ++i) mean += get(v, plan.corner_neighbours[i], plane);
        const Vec3f x = (get(v, corner.vertex, plane) - mean / float(corner.last_neighbour - first)) * 0.25f;
        corner_shapes_[b] = projected_ ? corner_normals_[b] * dot(corner_normals_[b], x) : x;
    }
}

void PatchTransform::State::find_normals(const LevelPlan& plan, std::uint32_t f) {
    const Layout& layout = plan.layout;
    float* own = normals_.data() + std::size_t{3} * layout.plane * f;
    fold_boundary(plan, f, vertices(plan.level));
    kernels().normals(layout, vertices(plan.level) + std::size_t{3} * layout.plane * f, own);
    for (unsigned c = 0; c < 3; ++c)
        put(own, side_point(layout, c, 0), layout.plane, corner_normals_[topology_.base().faces()[f][c]]);
}

void PatchTransform::State::find_shapes(const LevelPlan& plan, std::uint32_t f) {
    const Layout& layout = plan.layout;
    const std::size_t plane = layout.plane, patch = 3 * plane * f;
    const float *v = vertices(plan.level) + patch, *normals = projected_ ? normals_.data() + patch : nullptr;
    float* own = shapes_.data() + patch;
    kernels().shape(layout, v, normals, own);
    for (unsigned s = 0; s < 3; ++s) {
        if (!sharp(f, s)) continue;
        for (int t = 1; t < layout.n; ++t) {
            const std::uint32_t at = side_point(layout, s, t);
            const Vec3f mean =
                (get(v, side_point(layout, s, t - 1), plane) + get(v, side_point(layout, s, t + 1), plane)) * 0.5f;
            Vec3f x = (get(v, at, plane) - mean) * 0.25f;
            if (projected_) {
                const Vec3f N = get(normals, at, plane);
                x = N * dot(N, x);
            }
            put(own, at, plane, x);
        }
    }
    for (unsigned c = 0; c < 3; ++c)
        put(own, side_point(layout, c, 0), plane, corner_shapes_[topology_.base().faces()[f][c]]);
}

void PatchTransform::State::lift(const LevelPlan& plan, std::uint32_t f, float sign) {
    const std::size_t plane = plan.layout.plane;
    float* v = vertices(plan.level);
    const float* d = details_.data();
    const auto sum_of = [&](std::uint32_t target) {
        Vec3f sum;
        for (std::uint32_t i = target == 0 ? 0 : plan.targets[target - 1].last_source;
             i < plan.targets[target].last_source; ++i)
            sum += get(d, plan.sources[i].detail, 3 * plane) * (sign * plan.sources[i].weight);
        return sum;
    };
    const std::uint32_t first = plan.first_target[f], last = plan.first_target[f + 1];
    // The kernel spoils the base vertices, whose edges beyond the patch it cannot see: their own value is kept aside.
    std::array<Vec3f, 3> corners;
    for (unsigned c = 0; c < 3; ++c) corners[c] = get(v + 3 * plane * f, side_point(plan.layout, c, 0), plane);
    kernels().lift(plan.layout, weights_.lift, sign, d + 9 * plane * f, v + 3 * plane * f);
    for (unsigned c = 0; c < 3; ++c) put(v + 3 * plane * f, side_point(plan.layout, c, 0), plane, corners[c]);
    for (std::uint32_t t = first; t < last; ++t)
        put(v, plan.targets[t].vertex, plane, get(v, plan.targets[t].vertex, plane) + sum_of(t));
}

/// Fills the ghosts that the stencils read (for seeded rules, those of vertices came with the estimates), then
/// predicts.
void PatchTransform::State::predict(const LevelPlan& plan, std::uint32_t f, float sign) {
    sync_vertices(plan, f, seeded_ ? shapes_.data() : vertices(plan.level));
    const std::size_t plane = plan.layout.plane, patch = 3 * plane * f;
    float* d = details_.data() + 3 * patch;
    const float* v = vertices(plan.level) + patch;
    const float* shape = seeded_ ? shapes_.data() + patch : nullptr;
    if (projected_)
        kernels().predict_along_normal(plan.layout, weights_.position, weights_.shape, sign, v, shape,
                                       normals_.data() + patch, d);
    else
        kernels().predict(plan.layout, weights_.position, weights_.shape, sign, v, shape, d);
    predict_listed(plan, f, sign);
}

void PatchTransform::State::predict_listed(const LevelPlan& plan, std::uint32_t f, float sign) {
    const std::size_t plane = plan.layout.plane;
    const float* v = vertices(plan.level);
    for (std::uint32_t e = plan.first_listed[f]; e < plan.first_listed[f + 1]; ++e) {
        const ListedEdge& edge = plan.listed[e];
        Vec3f P;
        for (std::uint32_t i = e == 0 ? 0 : plan.listed[e - 1].last_term; i < edge.last_term; ++i) {
            const ListedTerm& t = plan.terms[i];
            P += get(v, t.vertex, plane) * t.position;
            if (seeded_) P += get(shapes_.data(), t.vertex, plane) * t.shape;
        }
        if (projected_ && edge.projected) {
            const Vec3f m = (get(v, edge.ends[0], plane) + get(v, edge.ends[1], plane)) * 0.5f;
            const Vec3f n =
                normalized(get(normals_.data(), edge.ends[0], plane) + get(normals_.data(), edge.ends[1], plane));
            P = m + n * dot(n, P - m);
        }
        const std::uint32_t kept = plan.listed_slot(e, faces());
        put(details_.data(), kept, 3 * plane, get(details_.data(), kept, 3 * plane) + P * sign);
        put(details_.data(), edge.slot, 3 * plane, {});  // where the kernel predicted too
    }
}

void PatchTransform::State::loop_even(const LevelPlan& plan, std::uint32_t f, bool inverse, Scratch& scratch) {
    const Layout& layout = plan.layout;
    const std::size_t plane = layout.plane;
    float* v = vertices(plan.level) + 3 * plane * f;
    const float* d = details_.data() + 9 * plane * f;
    // What the kernel spoils is worked out before it: sharp sides, then base vertices.
    scratch.points.clear();
    for (unsigned s = 0; s < 3; ++s)
        for (int t = 1; t < layout.n && sharp(f, s); ++t) {
            const Vec3f sum =
                get(d, side_detail(layout, s, t - 1), 3 * plane) + get(d, side_detail(layout, s, t), 3 * plane);
            const Vec3f at = get(v, side_point(layout, s, t), plane);
            scratch.points.push_back(inverse ? (at - sum * 0.25f) * 2.0f : at * 0.5f + sum * 0.25f);
        }
    for (unsigned c = 0; c < 3; ++c) {
        const std::uint32_t b = topology_.base().faces()[f][c];
        const Corner& corner = plan.corners[b];
        Vec3f sum;
        for (std::uint32_t i = b == 0 ? 0 : plan.corners[b - 1].last_loop_edge; i < corner.last_loop_edge; ++i)
            sum += get(details_.data(), plan.corner_loop_edges[i], 3 * plane);
        const Vec3f at = get(v, side_point(layout, c, 0), plane);
        scratch.points.push_back(inverse ? (at - sum * corner.loop_b) / corner.loop_a
                                         : at * corner.loop_a + sum * corner.loop_b);
    }
    kernels().loop_even(layout, inverse, d, v);
    const Vec3f* point = scratch.points.data();
    for (unsigned s = 0; s < 3; ++s)
        for (int t = 1; t < layout.n && sharp(f, s); ++t) put(v, side_point(layout, s, t), plane, *point++);
    for (unsigned c = 0; c < 3; ++c) put(v, side_point(layout, c, 0), plane, *point++);
}

void PatchTransform::State::hide_listed(const LevelPlan& plan, std::uint32_t f) {
    const std::size_t stride = 3 * plan.layout.plane;
    float* d = details_.data();
    for (std::uint32_t e = plan.first_listed[f]; e < plan.first_listed[f + 1]; ++e) {
        put(d, plan.listed_slot(e, faces()), stride, get(d, plan.listed[e].slot, stride));
        put(d, plan.listed[e].slot, stride, {});
    }
}

void PatchTransform::State::show_listed(const LevelPlan& plan, std::uint32_t f) {
    const std::size_t stride = 3 * plan.layout.plane;
    float* d = details_.data();
    for (std::uint32_t e = plan.first_listed[f]; e < plan.first_listed[f + 1]; ++e)
        put(d, plan.listed[e].slot, stride, get(d, plan.listed_slot(e, faces()), stride));
}

}  // namespace mvw
