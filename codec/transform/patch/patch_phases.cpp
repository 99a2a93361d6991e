#include <cstring>

#include "codec/transform/patch/patch_state.h"

namespace mvw {

namespace {

Vec3f get(const float* from, unsigned lanes) {
    return {from[0], from[lanes], from[2 * lanes]};
}
void put(float* to, unsigned lanes, const Vec3f& value) {
    to[0] = value.x;
    to[lanes] = value.y;
    to[2 * lanes] = value.z;
}

void add_to(ListedDetail& d, const Vec3f& more) {
    d.x += more.x;
    d.y += more.y;
    d.z += more.z;
}
template <typename Row>
std::span<const Row> of_patch(const std::vector<Row>& rows, const PatchRuns& first, std::uint32_t f) {
    return std::span(rows).subspan(first[f], first[f + 1] - first[f]);
}

}  // namespace

/// What the patch holds of others' vertices, from their owners' places in `from`.
void PatchTransform::State::copy_ghosts(const LevelPlan& plan, std::uint32_t f, const float* from, float* to) const {
    float* own = to + plan.patch_vertices(f);
    for (unsigned s = 0; s < 3; ++s) {
        const Link& next = link(f, s);
        if (next.patch == kNone) continue;
        const float* other = from + plan.patch_vertices(next.patch);
        if (!next.owned) kernels().copy(plan.side_vertices[s][next.side], other, own);
        kernels().copy(plan.ghosts[s][next.side], other, own);
    }
    kernels().copy(of_patch(plan.fixes, plan.first_fix, f), from, to);
}

/// Adds the neighbours' shares to the vertices that the patch owns.
void PatchTransform::State::collect(const LevelPlan& plan, std::uint32_t f, float* v) const {
    float* own = v + plan.patch_vertices(f);
    for (unsigned s = 0; s < 3; ++s) {
        const Link& next = link(f, s);
        if (next.patch == kNone) continue;
        const float* other = v + plan.patch_vertices(next.patch);
        if (next.owned) kernels().add_back(plan.side_vertices[next.side][s], other, own);
        kernels().add_back(plan.ghosts[next.side][s], other, own);
    }
    kernels().add_back_some(of_patch(plan.collected_fixes, plan.first_collected_fix, f), plan.fixes.data(), v);
}

void PatchTransform::State::fold_boundary(const LevelPlan& plan, std::uint32_t f, float* v) const {
    float* own = v + plan.patch_vertices(f);
    for (unsigned s = 0; s < 3; ++s)
        if (link(f, s).patch == kNone) kernels().copy(plan.folded[s], own, own);
}

/// Of the base vertices that the patch owns.
void PatchTransform::State::corner_normals(const LevelPlan& plan, std::uint32_t f, const float* v) {
    each_corner(plan, f, [&](std::uint32_t b, const Corner& corner) {
        const Vec3f p = get(v + corner.vertex, lanes_);
        Vec3f sum;
        for (std::uint32_t t = b == 0 ? 0 : plan.corners[b - 1].last_triangle; t < corner.last_triangle; ++t)
            sum += cross(get(v + plan.corner_triangles[t][0], lanes_) - p,
                         get(v + plan.corner_triangles[t][1], lanes_) - p);
        corner_normals_[b] = normalized(sum);
    });
}

void PatchTransform::State::corner_shapes(const LevelPlan& plan, std::uint32_t f, const float* v) {
    each_corner(plan, f, [&](std::uint32_t b, const Corner& corner) {
        const std::uint32_t first = b == 0 ? 0 : plan.corners[b - 1].last_neighbour;
        corner_shapes_[b] = {};
        if (first == corner.last_neighbour) return;
        Vec3f mean;
        for (std::uint32_t i = first; i < corner.last_neighbour; ++i)
            mean += get(v + plan.corner_neighbours[i], lanes_);
        const Vec3f x = (get(v + corner.vertex, lanes_) - mean / float(corner.last_neighbour - first)) * 0.25f;
        corner_shapes_[b] = projected_ ? corner_normals_[b] * dot(corner_normals_[b], x)
                            : seeded_  ? x
                                       : x * corner.vector_even;
    });
}

/// Normals of the group's own vertices. On a boundary this leaves the ghosts folded.
void PatchTransform::State::find_normals(const LevelPlan& plan, std::uint32_t g, float* v) {
    each_patch(g, [&](std::uint32_t f) { fold_boundary(plan, f, v); });
    kernels().normals(plan.layout, v + vertices_of(plan, g), normals_.data() + vertices_of(plan, g));
    each_patch(g, [&](std::uint32_t f) {
        for (unsigned c = 0; c < 3; ++c)
            put(normals_.data() + plan.patch_vertices(f) + plan.side_points[c][0], lanes_,
                corner_normals_[topology_.base().faces()[f][c]]);
    });
}

void PatchTransform::State::find_shapes(const LevelPlan& plan, std::uint32_t g, const float* v) {
    const std::size_t at = vertices_of(plan, g);
    kernels().shape(plan.layout, v + at, projected_ ? normals_.data() + at : nullptr, shapes_.data() + at);
    each_patch(g, [&](std::uint32_t f) { set_sharp_shapes(plan, f, v); });
}

/// Shape components along sharp sides, and at base vertices.
void PatchTransform::State::set_sharp_shapes(const LevelPlan& plan, std::uint32_t f, const float* v) {
    const float* own = v + plan.patch_vertices(f);
    float* shapes = shapes_.data() + plan.patch_vertices(f);
    for (unsigned s = 0; s < 3; ++s) {
        const std::vector<std::uint32_t>& points = plan.side_points[s];
        for (std::size_t t = 1; sharp(f, s) && t + 1 < points.size(); ++t) {
            const Vec3f mean = (get(own + points[t - 1], lanes_) + get(own + points[t + 1], lanes_)) * 0.5f;
            Vec3f x = (get(own + points[t], lanes_) - mean) * 0.25f;
            if (projected_) {
                const Vec3f N = get(normals_.data() + plan.patch_vertices(f) + points[t], lanes_);
                x = N * dot(N, x);
            }
            put(shapes + points[t], lanes_, seeded_ ? x : Vec3f{});
        }
        put(shapes + points[0], lanes_, corner_shapes_[topology_.base().faces()[f][s]]);
    }
}

void PatchTransform::State::hide_listed(const LevelPlan& plan, std::uint32_t f, Field& field) const {
    float* d = details_of(field, plan, f / lanes_);
    for (std::uint32_t e = plan.first_listed[f]; e < plan.first_listed[f + 1]; ++e) {
        float* at = d + plan.listed[e].edge;
        const Vec3f detail = get(at, lanes_);
        field.listed[e] = {detail.x, detail.y, detail.z};
        put(at, lanes_, {});
    }
}

void PatchTransform::State::show_listed(const LevelPlan& plan, std::uint32_t f, Field& field) const {
    float* d = details_of(field, plan, f / lanes_);
    for (std::uint32_t e = plan.first_listed[f]; e < plan.first_listed[f + 1]; ++e)
        put(d + plan.listed[e].edge, lanes_, {field.listed[e].x, field.listed[e].y, field.listed[e].z});
}

/// On sides that others own.
void PatchTransform::State::zero_foreign(const LevelPlan& plan, std::uint32_t f, Field& field) const {
    float* own = details_of(field, plan, f / lanes_) + f % lanes_;
    for (unsigned s = 0; s < 3; ++s)
        if (!link(f, s).owned) kernels().clear_points(plan.side_edges[s], own);
}

void PatchTransform::State::lift(const LevelPlan& plan, std::uint32_t g, Field& field, float sign, const float* in,
                                 float* out) {
    const std::size_t at = vertices_of(plan, g);
    if (lazy_) {
        if (in != out) std::memcpy(out + at, in + at, plan.layout.vertex_floats * sizeof(float));
        return;
    }
    FloatWeights w = weights_.lift;
    w.ends *= sign, w.opp *= sign, w.wings *= sign, w.far *= sign;
    kernels().lift(plan.layout, plan.lift_program, w, 1, &keep_[std::size_t{g} * kKeepCount * lanes_],
                   details_of(field, plan, g), in + at, out + at);
}

void PatchTransform::State::predict(const LevelPlan& plan, std::uint32_t g, const float* v, float sign) {
    const std::size_t at = vertices_of(plan, g);
    float* d = details_of(positions_, plan, g);
    const float* shape = seeded_ ? shapes_.data() + at : nullptr;
    if (projected_)
        kernels().predict_along_normal(plan.layout, weights_.position, weights_.shape, sign, v + at, shape,
                                       normals_.data() + at, d);
    else
        kernels().predict(plan.layout, weights_.position, weights_.shape, sign, v + at, shape, d);
    each_patch(g, [&](std::uint32_t f) { predict_listed(plan, f, v, sign); });
}

void PatchTransform::State::predict_listed(const LevelPlan& plan, std::uint32_t f, const float* v, float sign) {
    const ListedEdges lists = plan.listed_edges(f);
    kernels().predict_listed(lists, sign, v, seeded_ ? shapes_.data() : nullptr, projected_ ? normals_.data() : nullptr,
                             &positions_.listed[plan.first_listed[f]]);
    float* d = details_of(positions_, plan, f / lanes_);
    for (const ListedEdge& edge : lists.edges) put(d + edge.edge, lanes_, {});  // where the kernel predicted too
}

/// The vector transform's second component: d_x += sign * (second component of the odd rule on [v, 0]), and
/// x += sign * 3/8 (v - mean of ring), from the x of set_sharp_shapes().
void PatchTransform::State::predict_second(const LevelPlan& plan, std::uint32_t g, const float* v, float* x,
                                           float sign) {
    const std::size_t at = vertices_of(plan, g);
    kernels().predict(plan.layout, FloatWeights(kVectorShape), {}, sign, v + at, nullptr, details_of(second_, plan, g));
    const auto even = static_cast<float>(4 * kVectorEven) * sign;
    for (std::size_t i = at; i < at + plan.layout.vertex_floats; ++i) x[i] += even * shapes_.data()[i];
    each_patch(g, [&](std::uint32_t f) { predict_second_listed(plan, f, v, sign); });
}

void PatchTransform::State::predict_second_listed(const LevelPlan& plan, std::uint32_t f, const float* v, float sign) {
    const ListedEdges lists = plan.listed_edges(f);
    const std::uint32_t* vertex = lists.vertices + lists.first_vertex;
    ListedDetail* listed = &second_.listed[plan.first_listed[f]];
    for (const ListedEdge& edge : lists.edges) {
        Vec3f P;
        for (const float* w = lists.weights + edge.weights; vertex != lists.vertices + edge.last_vertex; w += 2)
            P += get(v + *vertex++, lanes_) * w[1];
        add_to(*listed++, P * sign);
        put(details_of(second_, plan, f / lanes_) + edge.edge, lanes_, {});
    }
}

/// Loop's even rule on sharp sides and at base vertices, worked out before the kernel spoils them.
void PatchTransform::State::loop_specials(const LevelPlan& plan, std::uint32_t f, bool inverse, const float* v) {
    const float *own = v + plan.patch_vertices(f), *all = positions_.details.data();
    const float* d = details_of(positions_, plan, f / lanes_) + f % lanes_;
    const std::size_t block = std::size_t{1} << (levels_ - 1);
    for (unsigned s = 0; s < 3; ++s) {
        Vec3f* special = &loop_specials_[(std::size_t{3} * f + s) * block];
        const std::uint32_t b = topology_.base().faces()[f][s];
        if (topology_.corner_owner(b) == std::pair(f, s)) {
            const Corner& corner = plan.corners[b];
            Vec3f sum;
            for (std::uint32_t i = b == 0 ? 0 : plan.corners[b - 1].last_loop_edge; i < corner.last_loop_edge; ++i)
                sum += get(all + plan.corner_loop_edges[i], lanes_);
            const Vec3f at = get(v + corner.vertex, lanes_);
            special[0] =
                inverse ? (at - sum * corner.loop_b) / corner.loop_a : at * corner.loop_a + sum * corner.loop_b;
        }
        if (!sharp(f, s) || !topology_.owns_side(f, s)) continue;
        for (std::size_t t = 1; t < plan.side_edges[s].size(); ++t) {
            const Vec3f sum = get(d + plan.side_edges[s][t - 1], lanes_) + get(d + plan.side_edges[s][t], lanes_);
            const Vec3f at = get(own + plan.side_points[s][t], lanes_);
            special[t] = inverse ? (at - sum * 0.25f) * 2.0f : at * 0.5f + sum * 0.25f;
        }
    }
}

void PatchTransform::State::put_loop_specials(const LevelPlan& plan, std::uint32_t f, float* v) const {
    float* own = v + plan.patch_vertices(f);
    const std::size_t block = std::size_t{1} << (levels_ - 1);
    for (unsigned s = 0; s < 3; ++s) {
        const Vec3f* special = &loop_specials_[(std::size_t{3} * f + s) * block];
        if (topology_.corner_owner(topology_.base().faces()[f][s]) == std::pair(f, s))
            put(own + plan.side_points[s][0], lanes_, special[0]);
        if (!sharp(f, s) || !topology_.owns_side(f, s)) continue;
        for (std::size_t t = 1; t < plan.side_edges[s].size(); ++t)
            put(own + plan.side_points[s][t], lanes_, special[t]);
    }
}

/// The edges' shares of Loop's even rule: v' = 2/5 v + 1/10 sum of e' over six edges; or its inverse. Sharp sides and
/// base vertices come out wrong.
void PatchTransform::State::loop_even(const LevelPlan& plan, std::uint32_t g, bool inverse, const float* in,
                                      float* out) {
    FloatWeights w;
    w.ends = inverse ? -0.25f : 0.1f;
    kernels().lift(plan.layout, plan.lift_program, w, inverse ? 2.5f : 0.4f,
                   &keep_[std::size_t{g} * kKeepCount * lanes_], details_of(positions_, plan, g),
                   in + vertices_of(plan, g), out + vertices_of(plan, g));
}

}  // namespace mvw
