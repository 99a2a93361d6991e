#include <algorithm>
#include <cassert>

#include "codec/transform/patch/patch_state.h"

namespace mvw {

PatchTransform::State::State(const BaseMesh& base, unsigned levels, const TransformOptions& options,
                             std::span<const std::uint8_t> creases, unsigned threads)
    : workers(threads),
      topology_(base),
      levels_(levels),
      options_(options),
      rule_(predict_rule(options.kind)),
      lazy_(is_lazy(options.kind)),
      seeded_(rule_ == PredictRule::Seeded || rule_ == PredictRule::SeededNormal),
      projected_(rule_ == PredictRule::SeededNormal),
      plans_(make_plans(topology_, levels, options, creases)),
      corner_normals_(base.vertex_count()),
      corner_shapes_(base.vertex_count()),
      scratch_(workers.count()) {
    weights_.lift = FloatWeights(ordinary_lifting(options));
    weights_.position = FloatWeights(rule_ == PredictRule::Butterfly ? kButterflyPosition
                                     : rule_ == PredictRule::Loop    ? kLoopPosition
                                                                     : kInterpPosition);
    weights_.shape = FloatWeights(seeded_ ? kInterpShape : TenWeights{});
    for (std::uint32_t f = 0; f < faces(); ++f)
        for (unsigned s = 0; s < 3; ++s) {
            const std::uint32_t e = base.edge_of(f, s);
            sharp_.push_back(base.edges()[e].face[1] == kNone || (!creases.empty() && creases[e] != 0) ? 1 : 0);
        }
    if (levels == 0) return;
    const LevelPlan& last = plans_.back();
    vertices_[0].resize(last.vertex_floats(faces()));
    if (levels > 1) vertices_[1].resize(plans_[levels - 2].vertex_floats(faces()));
    for (const LevelPlan& plan : plans_) details_.resize(std::max(details_.size(), plan.detail_floats(faces())));
    if (projected_ || options.local_frames) normals_.resize(vertices_[0].size());
    if (seeded_) shapes_.resize(vertices_[0].size());
    for (Scratch& s : scratch_) s.points.reserve(std::size_t{3} * static_cast<unsigned>(last.layout.n) + 3);
}

/// Seeded rules only: normals and shape components from the vertices of the plan's level.
void PatchTransform::State::estimate(unsigned w, const LevelPlan& plan) {
    if (!seeded_) return;
    const auto [begin, end] = share(w, topology_.base().vertex_count());
    if (projected_) corner_normals(plan, begin, end);
    corner_shapes(plan, begin, end);
    workers.sync();
    each_patch(w, [&](std::uint32_t f) {
        sync_vertices(plan, f, vertices(plan.level));
        if (projected_) find_normals(plan, f);
        find_shapes(plan, f);
    });
    workers.sync();
}

void PatchTransform::State::synthesis_step(unsigned w, const LevelPlan& plan, const Vec3f* coefficients, bool last,
                                           Vec3f* positions) {
    float* v = vertices(plan.level);
    if (options_.local_frames) {
        const auto [begin, end] = share(w, topology_.base().vertex_count());
        corner_normals(plan, begin, end);
        workers.sync();
    }
    each_patch(w, [&](std::uint32_t f) {
        const std::size_t patch = std::size_t{3} * plan.layout.plane * f;
        load_details(plan, f, coefficients);
        zero_ghosts(plan, f);
        if (options_.local_frames) {
            sync_vertices(plan, f, v);
            find_normals(plan, f);
            kernels().turn(plan.layout, true, v + patch, normals_.data() + patch, details_.data() + 3 * patch);
        }
        hide_listed(plan, f);
    });
    workers.sync();
    if (!lazy_) {
        each_patch(w, [&](std::uint32_t f) {
            sync_edges(plan, f);
            lift(plan, f, 1);
        });
        workers.sync();
    }
    estimate(w, plan);
    const bool loop = rule_ == PredictRule::Loop;
    // One pass over memory where nothing has to wait for the neighbours.
    each_patch(w, [&](std::uint32_t f) {
        predict(plan, f, 1);
        show_listed(plan, f);
        if (!loop) hand_over(plan, f, last, positions);
    });
    workers.sync();
    if (!loop) return;
    each_patch(w, [&](std::uint32_t f) {
        sync_edges(plan, f);
        loop_even(plan, f, false, scratch_[w]);
        hand_over(plan, f, last, positions);
    });
    workers.sync();
}

/// Vertices of the next level to its planes or, from the last step, out.
void PatchTransform::State::hand_over(const LevelPlan& plan, std::uint32_t f, bool last, Vec3f* positions) {
    if (last) {
        store_details(plan, f, positions);
        store_vertices(plan, f, positions);
        return;
    }
    const std::size_t patch = std::size_t{3} * plan.layout.plane * f;
    const LevelPlan& next = plans_[plan.level + 1];
    kernels().interleave(plan.layout, vertices(plan.level) + patch, details_.data() + 3 * patch, next.layout,
                         vertices(plan.level + 1) + std::size_t{3} * next.layout.plane * f);
}

void PatchTransform::State::analysis_step(unsigned w, const LevelPlan& plan, const Vec3f* positions, bool first,
                                          Vec3f* coefficients) {
    float* v = vertices(plan.level);
    each_patch(w, [&](std::uint32_t f) {
        if (first) {
            load_vertices(plan, f, positions);
            load_details(plan, f, positions);
        } else {
            const LevelPlan& fine = plans_[plan.level + 1];
            kernels().deinterleave(fine.layout, vertices(plan.level + 1) + std::size_t{3} * fine.layout.plane * f,
                                   plan.layout, v + std::size_t{3} * plan.layout.plane * f,
                                   details_.data() + std::size_t{9} * plan.layout.plane * f);
        }
        zero_ghosts(plan, f);
    });
    workers.sync();
    if (rule_ == PredictRule::Loop) {
        each_patch(w, [&](std::uint32_t f) {
            sync_vertices(plan, f, v);
            sync_edges(plan, f);
        });
        workers.sync();
        each_patch(w, [&](std::uint32_t f) { loop_even(plan, f, true, scratch_[w]); });
        workers.sync();
    }
    estimate(w, plan);
    each_patch(w, [&](std::uint32_t f) {
        hide_listed(plan, f);
        predict(plan, f, -1);
    });
    workers.sync();
    if (!lazy_) {
        each_patch(w, [&](std::uint32_t f) {
            sync_edges(plan, f);
            lift(plan, f, -1);
        });
        workers.sync();
    }
    if (options_.local_frames) {
        const auto [begin, end] = share(w, topology_.base().vertex_count());
        corner_normals(plan, begin, end);
        workers.sync();
    }
    each_patch(w, [&](std::uint32_t f) {
        const std::size_t patch = std::size_t{3} * plan.layout.plane * f;
        show_listed(plan, f);
        if (options_.local_frames) {
            sync_vertices(plan, f, v);
            find_normals(plan, f);
            kernels().turn(plan.layout, false, v + patch, normals_.data() + patch, details_.data() + 3 * patch);
        }
        store_details(plan, f, coefficients);
    });
    workers.sync();
}

void PatchTransform::State::synthesize(unsigned w, std::span<const Vec3f> coefficients, unsigned level,
                                       std::span<Vec3f> positions) {
    each_patch(w, [&](std::uint32_t f) { load_vertices(plans_[0], f, coefficients.data()); });
    workers.sync();
    for (unsigned j = 0; j < level; ++j)
        synthesis_step(w, plans_[j], coefficients.data(), j + 1 == level, positions.data());
}

void PatchTransform::State::analyze(unsigned w, std::span<const Vec3f> positions, std::span<Vec3f> coefficients) {
    for (unsigned j = levels_; j-- > 0;)
        analysis_step(w, plans_[j], positions.data(), j + 1 == levels_, coefficients.data());
    each_patch(w, [&](std::uint32_t f) { store_vertices(plans_[0], f, coefficients.data()); });
}

PatchTransform::PatchTransform(const BaseMesh& base, unsigned levels, const TransformOptions& options,
                               std::span<const std::uint8_t> creases, unsigned threads)
    : state_(std::make_unique<State>(base, levels, options, creases, threads)) {}
PatchTransform::~PatchTransform() = default;
PatchTransform::PatchTransform(PatchTransform&&) noexcept = default;
PatchTransform& PatchTransform::operator=(PatchTransform&&) noexcept = default;

void PatchTransform::analyze(std::span<const Vec3f> positions, std::span<Vec3f> coefficients) {
    assert(positions.size() == coefficients.size() && positions.size() == state_->vertex_count(state_->levels()));
    // Base vertices in no face, and a transform of no levels: as they are.
    std::copy_n(positions.begin(), state_->vertex_count(0), coefficients.begin());
    if (state_->levels() == 0) return;
    state_->workers.run([&](unsigned w) { state_->analyze(w, positions, coefficients); });
}

void PatchTransform::synthesize(std::span<const Vec3f> coefficients, unsigned level, std::span<Vec3f> positions) {
    assert(level <= state_->levels() && positions.size() == state_->vertex_count(level));
    std::copy_n(coefficients.begin(), state_->vertex_count(0), positions.begin());
    if (level == 0) return;
    state_->workers.run([&](unsigned w) { state_->synthesize(w, coefficients, level, positions); });
}

}  // namespace mvw
