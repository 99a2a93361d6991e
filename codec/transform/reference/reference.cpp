#include "codec/transform/reference/reference.h"

#include <algorithm>

#include "codec/transform/frames.h"

namespace mvw {

namespace {

/// Unit vertex normals, area-weighted; zero where they cancel.
std::vector<Vec3> vertex_normals(const Level& level, std::span<const Vec3> v) {
    std::vector<Vec3> normals(level.vertex_count);
    for (const Face& f : level.faces) {
        const Vec3 n = cross(v[f[1]] - v[f[0]], v[f[2]] - v[f[0]]);
        for (const std::uint32_t c : f) normals[c] += n;
    }
    for (Vec3& n : normals) n = normalized(n);
    return normals;
}

/// x = (v - mean of its ring)/4.
std::vector<Vec3> estimated_shape(const Level& level, std::span<const Vec3> v) {
    std::vector<Vec3> x(level.vertex_count);
    std::vector<std::uint32_t> ring;
    for (std::uint32_t i = 0; i < level.vertex_count; ++i) {
        shape_neighbours(level, i, ring);
        if (ring.empty()) continue;
        Vec3 mean;
        for (const std::uint32_t r : ring) mean += v[r];
        x[i] = (v[i] - mean / double(ring.size())) * 0.25;
    }
    return x;
}

void add_ordinary(const TenPoints& p, const TenWeights& w, std::vector<LiftTerm>& out) {
    for (const std::uint32_t v : p.ends) out.push_back({v, w.ends});
    for (const std::uint32_t v : p.opp) out.push_back({v, w.opp});
    for (const std::uint32_t v : p.wings) out.push_back({v, w.wings});
    for (const std::uint32_t v : p.far) out.push_back({v, w.far});
}

enum class Turn : std::uint8_t { ToModel, ToLocal };

void turn_details(const Level& level, std::span<Vec3> v, Turn turn) {
    const std::vector<Vec3> normals = vertex_normals(level, v);
    for (const Level::Edge& e : level.edges) {
        const std::uint32_t a = level.from(e.half), b = level.to(e.half);
        const Frame<double> frame = make_frame(normals[a] + normals[b], v[b] - v[a]);
        v[e.odd] = turn == Turn::ToModel ? frame.to_model(v[e.odd]) : frame.to_local(v[e.odd]);
    }
}

}  // namespace

ReferenceTransform::ReferenceTransform(const BaseMesh& base, unsigned levels, const TransformOptions& options,
                                       std::span<const std::uint8_t> creases)
    : options_(options) {
    for (unsigned j = 0; j < levels; ++j) add_step(base, j, creases);
}

void ReferenceTransform::add_step(const BaseMesh& base, unsigned j, std::span<const std::uint8_t> creases) {
    Step step;
    step.level = make_level(base, j, creases);
    const PredictRule rule = predict_rule(options_.kind);
    const bool four = options_.kind == TransformKind::Loop && options_.loop_template == 4;
    const TenWeights ordinary = ordinary_lifting(options_);
    const DiscreteLifting lifting(step.level, rule, options_.s);
    step.first_term.push_back(0);
    step.first_lift.push_back(0);
    for (std::uint32_t e = 0; e < step.level.edges.size(); ++e) {
        predict_terms(step.level, e, rule, options_.s, step.terms);
        if (!is_lazy(options_.kind)) {
            if (is_ordinary(step.level, e))
                add_ordinary(step.level.ten_points(e), ordinary, step.lifts);
            else
                lifting.weights(e, four, step.lifts);
        }
        step.first_term.push_back(step.terms.size());
        step.first_lift.push_back(step.lifts.size());
    }
    steps_.push_back(std::move(step));
}

void ReferenceTransform::lift(const Step& step, std::span<Vec3> v, double sign) const {
    for (std::size_t e = 0; e < step.level.edges.size(); ++e)
        for (std::size_t i = step.first_lift[e]; i < step.first_lift[e + 1]; ++i)
            v[step.lifts[i].vertex] += (sign * step.lifts[i].weight) * v[step.level.edges[e].odd];
}

void ReferenceTransform::predict(const Step& step, std::span<Vec3> v, double sign) const {
    const Level& level = step.level;
    const PredictRule rule = predict_rule(options_.kind);
    const bool project = rule == PredictRule::SeededNormal;
    std::vector<Vec3> x(level.vertex_count), normals;
    if (rule == PredictRule::Seeded || project) x = estimated_shape(level, v);
    if (project) {
        normals = vertex_normals(level, v);
        for (std::uint32_t i = 0; i < level.vertex_count; ++i) x[i] = normals[i] * dot(normals[i], x[i]);
    }
    for (std::size_t e = 0; e < level.edges.size(); ++e) {
        Vec3 p;
        for (std::size_t i = step.first_term[e]; i < step.first_term[e + 1]; ++i)
            p += step.terms[i].position * v[step.terms[i].vertex] + step.terms[i].shape * x[step.terms[i].vertex];
        const Level::Edge& edge = level.edges[e];
        if (project && !edge.sharp) {
            const std::uint32_t a = level.from(edge.half), b = level.to(edge.half);
            const Vec3 n = normalized(normals[a] + normals[b]), middle = (v[a] + v[b]) * 0.5;
            p = middle + n * dot(n, p - middle);
        }
        v[edge.odd] += sign * p;
    }
}

void ReferenceTransform::loop_even(const Step& step, std::span<Vec3> v, bool forward) const {
    std::vector<std::uint32_t> around;
    for (std::uint32_t i = 0; i < step.level.vertex_count; ++i) {
        loop_edges(step.level, i, around);
        const LoopEven rule = mvw::loop_even(step.level, i);
        Vec3 sum;
        for (const std::uint32_t e : around) sum += v[step.level.edges[e].odd];
        v[i] = forward ? (v[i] - rule.b * sum) / rule.a : rule.a * v[i] + rule.b * sum;
    }
}

/// x' = x + 3/8 (v - mean of its ring) at regular vertices, alpha/16 in place of 3/8 at irregular ones, x' = x on
/// sharp.
void ReferenceTransform::vector_even(const Step& step, std::span<const Vec3> v, std::span<Vec3> x, double sign) const {
    std::vector<std::uint32_t> ring;
    for (std::uint32_t i = 0; i < step.level.vertex_count; ++i) {
        if (step.level.sharp(i)) continue;
        shape_neighbours(step.level, i, ring);
        Vec3 mean;
        for (const std::uint32_t r : ring) mean += v[r];
        const double weight = step.level.regular(i) ? kVectorEven : kVectorEvenIrregular;
        x[i] += (sign * weight) * (v[i] - mean / double(ring.size()));
    }
}

/// d_x = e'_x - (second component of the odd rule on [v, 0]), which is zero off the ordinary edges.
void ReferenceTransform::vector_odd(const Step& step, std::span<const Vec3> v, std::span<Vec3> x, double sign) const {
    for (std::uint32_t e = 0; e < step.level.edges.size(); ++e) {
        if (!is_ordinary(step.level, e)) continue;
        const TenPoints p = step.level.ten_points(e);
        Vec3 sum;
        for (const std::uint32_t i : p.ends) sum += kVectorShape.ends * v[i];
        for (const std::uint32_t i : p.opp) sum += kVectorShape.opp * v[i];
        for (const std::uint32_t i : p.wings) sum += kVectorShape.wings * v[i];
        for (const std::uint32_t i : p.far) sum += kVectorShape.far * v[i];
        x[step.level.edges[e].odd] += sign * sum;
    }
}

void ReferenceTransform::analyze(std::span<const Vec3> positions, std::span<Vec3> coefficients,
                                 std::span<Vec3> shape) const {
    std::copy(positions.begin(), positions.end(), coefficients.begin());
    std::fill(shape.begin(), shape.end(), Vec3{});
    for (std::size_t j = steps_.size(); j-- > 0;) {
        const Step& step = steps_[j];
        if (predict_rule(options_.kind) == PredictRule::Loop) loop_even(step, coefficients, true);
        if (!shape.empty()) {
            vector_even(step, coefficients, shape, -1);
            vector_odd(step, coefficients, shape, -1);
            lift(step, shape, -1);
        }
        predict(step, coefficients, -1);
        lift(step, coefficients, -1);
        if (options_.local_frames) turn_details(step.level, coefficients, Turn::ToLocal);
    }
}

void ReferenceTransform::synthesize(std::span<const Vec3> coefficients, unsigned level, std::span<Vec3> positions,
                                    std::span<Vec3> shape) const {
    std::copy_n(coefficients.begin(), positions.size(), positions.begin());
    for (unsigned j = 0; j < level; ++j) {
        const Step& step = steps_[j];
        if (options_.local_frames) turn_details(step.level, positions, Turn::ToModel);
        lift(step, positions, 1);
        predict(step, positions, 1);
        if (!shape.empty()) {
            lift(step, shape, 1);
            vector_odd(step, positions, shape, 1);
            vector_even(step, positions, shape, 1);
        }
        if (predict_rule(options_.kind) == PredictRule::Loop) loop_even(step, positions, false);
    }
}

}  // namespace mvw
