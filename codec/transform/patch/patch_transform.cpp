#include <algorithm>
#include <cassert>
#include <cstring>
#include <numeric>

#include "codec/transform/patch/patch_state.h"
#include "codec/transform/tables.h"

namespace mvw {

PatchTransform::State::State(std::shared_ptr<const TransformTables> tables, unsigned levels, unsigned threads,
                             bool updates)
    : workers(threads),
      tables_(std::move(tables)),
      topology_(tables_->topology()),
      levels_(levels),
      lanes_(lanes_for(faces())),
      groups_((faces() + lanes_ - 1) / lanes_),
      kernels_(mvw::kernels(lanes_)),
      links_(std::size_t{3} * faces()),
      options_(tables_->options()),
      rule_(predict_rule(options_.kind)),
      lazy_(is_lazy(options_.kind)),
      seeded_(rule_ == PredictRule::Seeded || rule_ == PredictRule::SeededNormal),
      projected_(rule_ == PredictRule::SeededNormal),
      corner_normals_(topology_.base().vertex_count()),
      corner_shapes_(topology_.base().vertex_count()) {
    const BaseMesh& base = topology_.base();
    const std::span<const std::uint8_t> creases = tables_->creases();
    weights_.lift = FloatWeights(ordinary_lifting(options_));
    weights_.position = FloatWeights(rule_ == PredictRule::Butterfly ? kButterflyPosition
                                     : rule_ == PredictRule::Loop    ? kLoopPosition
                                                                     : kInterpPosition);
    weights_.shape = FloatWeights(seeded_ ? kInterpShape : TenWeights{});
    keep_.resize(std::size_t{groups_} * kKeepCount * lanes_);
    for (std::uint32_t f = 0; f < faces(); ++f) {
        std::uint32_t* keep = &keep_[std::size_t{f / lanes_} * kKeepCount * lanes_ + f % lanes_];
        keep[kKeepAll * lanes_] = ~0u;
        for (unsigned s = 0; s < 3; ++s) {
            const std::uint32_t e = base.edge_of(f, s);
            sharp_.push_back(base.edges()[e].face[1] == kNone || (!creases.empty() && creases[e] != 0) ? 1 : 0);
            const std::uint32_t g = topology_.neighbour(f, s);
            links_[std::size_t{3} * f + s] = {g == kNone ? kNone : g,
                                              static_cast<std::uint8_t>(topology_.neighbour_side(f, s)),
                                              topology_.owns_side(f, s)};
            if (topology_.owns_side(f, s)) keep[(kKeepSide + s) * lanes_] = ~0u;
            if (topology_.corner_owner(base.faces()[f][s]) == std::pair(f, s)) keep[(kKeepCorner + s) * lanes_] = ~0u;
        }
    }
    if (levels == 0) return;
    find_groups_around();
    choose_stages();
    const std::uint32_t slots = std::max(place_in_slots(synthesis_pipelines_, synthesis_slots_),
                                         place_in_slots(analysis_pipelines_, analysis_slots_));
    make_field(positions_, updates && rule_ != PredictRule::Loop, slots);
    if (options_.kind == TransformKind::Vector) make_field(second_, false, slots);
    const std::size_t floats = positions_.arrived.back().size();
    if (projected_ || options_.local_frames) normals_ = Floats(floats);
    if (finds_shapes()) shapes_ = Floats(floats);
    nothing_ = Floats(std::size_t{3} << (levels - 1));
    nowhere_ = Floats(groups_ * nothing_.size());
    if (rule_ == PredictRule::Loop) {
        positions_.evens = Floats(floats);
        loop_specials_.resize((std::size_t{3} * faces()) << (levels - 1));
    }
    if (updates && rule_ != PredictRule::Loop)
        for (Groups* groups :
             {&active_.details, &active_.arrived, &active_.handed, &active_.lift, &active_.shares, &active_.estimate})
            groups->resize(groups_);
}

/// Chooses each group's slot of all workers'; returns how many there are. Loop reads details of groups around, which
/// must stay: there each group has its own.
std::uint32_t PatchTransform::State::place_in_slots(const std::vector<Pipeline>& pipelines,
                                                    std::vector<std::uint32_t>& slots) const {
    std::uint32_t count = 0;
    for (const Pipeline& pipeline : pipelines) {
        for (const std::uint32_t slot : pipeline.slots()) slots.push_back(count + slot);
        count += pipeline.slot_count();
    }
    if (rule_ != PredictRule::Loop) return count;
    std::iota(slots.begin(), slots.end(), 0u);
    return groups_;
}

void PatchTransform::State::make_field(Field& field, bool updates, std::uint32_t slots) const {
    std::size_t listed = 0;
    for (unsigned j = 0; j < levels_; ++j) {
        const LevelPlan& plan = tables_->plan(j);
        field.arrived.emplace_back(std::size_t{groups_} * plan.layout.vertex_floats);
        if (updates) field.lifted.push_back(field.arrived.back());
        listed = std::max(listed, plan.listed.size());
    }
    if (updates) field.shares = field.lifted.back();
    const unsigned near = std::min(levels_, kNearLevel) - 1;
    field.details = Floats(std::max(std::size_t{groups_} * tables_->plan(near).layout.edge_floats,
                                    std::size_t{slots} * tables_->plan(levels_ - 1).layout.edge_floats));
    field.listed.resize(listed);
}

/// Groups that share a base vertex.
void PatchTransform::State::find_groups_around() {
    const BaseMesh& base = topology_.base();
    std::vector<std::vector<std::uint32_t>> at_vertex(base.vertex_count());
    for (std::uint32_t f = 0; f < faces(); ++f)
        for (const std::uint32_t v : base.faces()[f])
            if (at_vertex[v].empty() || at_vertex[v].back() != f / lanes_) at_vertex[v].push_back(f / lanes_);
    around_.first.push_back(0);
    for (std::uint32_t g = 0; g < groups_; ++g) {
        std::vector<std::uint32_t> around;
        each_patch(g, [&](std::uint32_t f) {
            for (const std::uint32_t v : base.faces()[f])
                around.insert(around.end(), at_vertex[v].begin(), at_vertex[v].end());
        });
        std::sort(around.begin(), around.end());
        around.erase(std::unique(around.begin(), around.end()), around.end());
        around_.next.insert(around_.next.end(), around.begin(), around.end());
        around_.first.push_back(static_cast<std::uint32_t>(around_.next.size()));
    }
}

void PatchTransform::State::choose_stages() {
    const bool loop = rule_ == PredictRule::Loop;
    const auto choose = [&](std::initializer_list<std::pair<Stage, bool>> stages, std::vector<Stage>& chosen,
                            std::vector<Pipeline>& pipelines) {
        for (const auto& [stage, used] : stages)
            if (used) chosen.push_back(stage);
        for (unsigned w = 0; w < workers.count(); ++w)
            pipelines.emplace_back(around_, share(w).first, share(w).second, static_cast<unsigned>(chosen.size()));
    };
    choose({{Normals, options_.local_frames},
            {Turn, options_.local_frames},
            {Lift, true},
            {Collect, true},
            {Corners, finds_shapes()},
            {Estimate, finds_shapes()},
            {Predict, true},
            {LoopEven, loop},
            {LoopCollect, loop}},
           synthesis_stages_, synthesis_pipelines_);
    choose({{Load, true},
            {LoopEven, loop},
            {LoopCollect, loop},
            {Corners, finds_shapes()},
            {Estimate, finds_shapes()},
            {Predict, true},
            {Lift, true},
            {Collect, true},
            {Normals, options_.local_frames},
            {Store, true}},
           analysis_stages_, analysis_pipelines_);
}

bool PatchTransform::State::restrict_to(std::span<const std::uint32_t> faces, unsigned first_level, unsigned level) {
    active_.all = active_.details.empty() || active_.held_level != level || first_level == 0;
    if (active_.all) return false;
    active_.first_level = first_level;
    std::fill(active_.details.begin(), active_.details.end(), std::uint8_t{0});
    std::fill(active_.handed.begin(), active_.handed.end(), std::uint8_t{0});
    for (const std::uint32_t f : faces) active_.details[f / lanes_] = 1;
    return true;
}

void PatchTransform::State::grow(const LevelPlan& plan, const Groups& from, Groups& to) const {
    grow_once(from, to);
    if (plan.level < kNearLevel) grow_once(Groups(to), to);
}
void PatchTransform::State::grow_once(const Groups& from, Groups& to) const {
    for (std::uint32_t g = 0; g < groups_; ++g) {
        const auto first = around_.next.begin() + around_.first[g], last = around_.next.begin() + around_.first[g + 1];
        to[g] = std::any_of(first, last, [&](std::uint32_t other) { return from[other] != 0; }) ? 1 : 0;
    }
}

/// The sets of an update's step.
void PatchTransform::State::choose_active(const LevelPlan& plan) {
    std::swap(active_.arrived, active_.handed);
    Groups& differ = active_.arrived;
    for (std::uint32_t g = 0; g < groups_ && plan.level + 1 >= active_.first_level; ++g)
        differ[g] |= active_.details[g];
    grow(plan, differ, active_.lift);
    grow(plan, active_.lift, active_.shares);
    grow(plan, active_.shares, active_.estimate);
    std::fill(active_.handed.begin(), active_.handed.end(), std::uint8_t{0});
}

bool PatchTransform::State::is_active(Stage stage, std::uint32_t g) const {
    if (active_.all || stage == Normals || stage == Corners) return true;
    return (stage == Collect ? active_.lift : stage == Estimate ? active_.estimate : active_.shares)[g] != 0;
}

/// Seeded rules, and the second component: normals and shape components at base vertices, then at all of a group's.
void PatchTransform::State::find_corners(const LevelPlan& plan, std::uint32_t g, const float* v) {
    each_patch(g, [&](std::uint32_t f) {
        if (projected_) corner_normals(plan, f, v);
        corner_shapes(plan, f, v);
    });
}
void PatchTransform::State::estimate(const LevelPlan& plan, std::uint32_t g, float* v) {
    each_patch(g, [&](std::uint32_t f) { copy_ghosts(plan, f, v, v); });
    if (projected_) find_normals(plan, g, v);
    find_shapes(plan, g, v);
}

/// Details between local frames and model axes. from: vertices, where patches hold what they own; v: a place for those
/// of this group with ghosts, `from` itself or apart.
void PatchTransform::State::turn_details(const LevelPlan& plan, std::uint32_t g, bool to_model, const float* from,
                                         float* v) {
    const std::size_t at = vertices_of(plan, g);
    if (v != from) std::memcpy(v + at, from + at, plan.layout.vertex_floats * sizeof(float));
    each_patch(g, [&](std::uint32_t f) { copy_ghosts(plan, f, from, v); });
    find_normals(plan, g, v);
    kernels().turn(plan.layout, to_model, v + at, normals_.data() + at, details_of(positions_, plan, g));
}

/// coefficients: null where the details are loaded already.
void PatchTransform::State::lift_forward(const LevelPlan& plan, std::uint32_t g, Field& field,
                                         const Vec3f* coefficients) {
    if (coefficients != nullptr) load_details(plan, g, coefficients, field);
    each_patch(g, [&](std::uint32_t f) { hide_listed(plan, f, field); });
    lift(plan, g, field, 1, field.arrived[plan.level].data(), lifting(field, plan));
}

void PatchTransform::State::collect_lift(const LevelPlan& plan, std::uint32_t g, Field& field, float sign) {
    float* v = lifting(field, plan);
    if (!lazy_)
        each_patch(g, [&](std::uint32_t f) {
            collect(plan, f, v);
            kernels().lift_listed(plan.lift_targets(f), field.listed.data(), sign, v);
        });
    const std::size_t at = vertices_of(plan, g);
    if (!active_.all) std::memcpy(lifted(field, plan) + at, v + at, plan.layout.vertex_floats * sizeof(float));
}

/// Vertices of the next level to where it starts or, from the last step, out.
void PatchTransform::State::hand_over(const LevelPlan& plan, std::uint32_t g, Field& field, const float* v,
                                      Vec3f* out) {
    if (out != nullptr) {
        store_details(plan, g, field, out);
        store_vertices(plan, g, v, out);
        return;
    }
    const LevelPlan& next = tables_->plan(plan.level + 1);
    const bool changed = kernels().interleave(plan.layout, v + vertices_of(plan, g), details_of(field, plan, g),
                                              next.layout, field.arrived[next.level].data() + vertices_of(next, g));
    if (!active_.all) active_.handed[g] = changed ? 1 : 0;
}

/// Loop's even rule: what the group's own edges have a share in, then the rest.
void PatchTransform::State::loop_shares(const LevelPlan& plan, std::uint32_t g, bool inverse, const float* in,
                                        float* out) {
    each_patch(g, [&](std::uint32_t f) {
        zero_foreign(plan, f, positions_);
        loop_specials(plan, f, inverse, in);
    });
    loop_even(plan, g, inverse, in, out);
}
void PatchTransform::State::loop_collect(const LevelPlan& plan, std::uint32_t g, float* v) {
    each_patch(g, [&](std::uint32_t f) {
        collect(plan, f, v);
        put_loop_specials(plan, f, v);
    });
}

void PatchTransform::State::predict_all(const Step& step, std::uint32_t g) {
    const LevelPlan& plan = step.plan;
    float *v = lifted(positions_, plan), *ghosts = seeded_ ? shapes_.data() : v;
    each_patch(g, [&](std::uint32_t f) { copy_ghosts(plan, f, ghosts, ghosts); });
    predict(plan, g, v, 1);
    each_patch(g, [&](std::uint32_t f) { show_listed(plan, f, positions_); });
    if (rule_ != PredictRule::Loop) hand_over(plan, g, positions_, v, step.positions);
    if (step.second == nullptr) return;
    float* x = lifted(second_, plan);
    predict_second(plan, g, v, x, 1);
    each_patch(g, [&](std::uint32_t f) { show_listed(plan, f, second_); });
    hand_over(plan, g, second_, x, step.second_out);
}

void PatchTransform::State::synthesize(Stage stage, const Step& step, std::uint32_t g) {
    const LevelPlan& plan = step.plan;
    switch (stage) {
        case Normals:
            each_patch(g, [&](std::uint32_t f) { corner_normals(plan, f, positions_.arrived[plan.level].data()); });
            break;
        case Turn:
            load_details(plan, g, step.coefficients, positions_);
            turn_details(plan, g, true, positions_.arrived[plan.level].data(), lifting(positions_, plan));
            break;
        case Lift:
            lift_forward(plan, g, positions_, options_.local_frames ? nullptr : step.coefficients);
            if (step.second != nullptr) lift_forward(plan, g, second_, step.second);
            break;
        case Collect:
            collect_lift(plan, g, positions_, 1);
            if (step.second != nullptr) collect_lift(plan, g, second_, 1);
            break;
        case Corners:
            if (seeded_ || step.second != nullptr) find_corners(plan, g, lifted(positions_, plan));
            break;
        case Estimate:
            if (seeded_ || step.second != nullptr) estimate(plan, g, lifted(positions_, plan));
            break;
        case Predict:
            predict_all(step, g);
            break;
        case LoopEven:
            loop_shares(plan, g, false, lifted(positions_, plan), positions_.evens.data());
            break;
        case LoopCollect:
            loop_collect(plan, g, positions_.evens.data());
            hand_over(plan, g, positions_, positions_.evens.data(), step.positions);
            break;
        case Load:
        case Store:
            break;  // of analysis
    }
}

/// Vertices and details of a step from those of the finer one or, on the finest level, from outside. `from`: null for
/// zero.
void PatchTransform::State::take_over(const LevelPlan& plan, std::uint32_t g, Field& field, const Vec3f* from) {
    float *v = field.arrived[plan.level].data(), *d = details_of(field, plan, g);
    if (plan.level + 1 < levels_) {
        const LevelPlan& fine = tables_->plan(plan.level + 1);
        kernels().deinterleave(fine.layout, lifted(field, fine) + vertices_of(fine, g), plan.layout,
                               v + vertices_of(plan, g), d);
    } else if (from != nullptr) {
        load_vertices(plan, g, from, v);
        load_details(plan, g, from, field);
    } else {
        std::fill_n(v + vertices_of(plan, g), plan.layout.vertex_floats, 0.0f);
        std::fill_n(d, plan.layout.edge_floats, 0.0f);
    }
}

void PatchTransform::State::unpredict_all(const Back& step, std::uint32_t g) {
    const LevelPlan& plan = step.plan;
    float *v = positions_.arrived[plan.level].data(), *ghosts = seeded_ ? shapes_.data() : v;
    each_patch(g, [&](std::uint32_t f) {
        copy_ghosts(plan, f, ghosts, ghosts);
        hide_listed(plan, f, positions_);
        if (step.second != nullptr) hide_listed(plan, f, second_);
    });
    if (step.second != nullptr) {
        predict_second(plan, g, v, second_.arrived[plan.level].data(), -1);
        each_patch(g, [&](std::uint32_t f) { zero_foreign(plan, f, second_); });
    }
    predict(plan, g, v, -1);
    each_patch(g, [&](std::uint32_t f) { zero_foreign(plan, f, positions_); });
}

void PatchTransform::State::analyze(Stage stage, const Back& step, std::uint32_t g) {
    const LevelPlan& plan = step.plan;
    float *arrived = positions_.arrived[plan.level].data(), *v = lifted(positions_, plan);
    switch (stage) {
        case Load:
            take_over(plan, g, positions_, step.positions);
            if (step.second != nullptr) take_over(plan, g, second_, nullptr);
            break;
        case LoopEven:
            loop_shares(plan, g, true, arrived, arrived);
            break;
        case LoopCollect:
            loop_collect(plan, g, arrived);
            break;
        case Corners:
            if (seeded_ || step.second != nullptr) find_corners(plan, g, arrived);
            break;
        case Estimate:
            if (seeded_ || step.second != nullptr) estimate(plan, g, arrived);
            break;
        case Predict:
            unpredict_all(step, g);
            break;
        case Collect:
            collect_lift(plan, g, positions_, -1);
            if (step.second != nullptr) collect_lift(plan, g, second_, -1);
            break;
        case Normals:
            each_patch(g, [&](std::uint32_t f) { corner_normals(plan, f, v); });
            break;
        case Store:
            each_patch(g, [&](std::uint32_t f) {
                show_listed(plan, f, positions_);
                if (step.second != nullptr) show_listed(plan, f, second_);
            });
            if (options_.local_frames) turn_details(plan, g, false, v, v);
            store_details(plan, g, positions_, step.coefficients);
            if (step.second != nullptr) store_details(plan, g, second_, step.second);
            break;
        case Lift:
            lift(plan, g, positions_, -1, arrived, v);
            if (step.second != nullptr)
                lift(plan, g, second_, -1, second_.arrived[plan.level].data(), lifted(second_, plan));
            break;
        case Turn:
            break;  // of synthesis
    }
}

void PatchTransform::State::synthesize(unsigned w, const Vec3f* coefficients, const Vec3f* second, unsigned level,
                                       Vec3f* positions, Vec3f* second_out) {
    each_group(w, [&](std::uint32_t g) {
        load_vertices(tables_->plan(0), g, coefficients, positions_.arrived[0].data());
        if (second != nullptr) load_vertices(tables_->plan(0), g, second, second_.arrived[0].data());
    });
    for (unsigned j = 0; j < level; ++j) {
        workers.sync();
        const bool last = j + 1 == level;
        const Step step{tables_->plan(j), coefficients, second, last ? positions : nullptr,
                        last ? second_out : nullptr};
        if (!active_.all) {
            if (w == 0) choose_active(step.plan);
            workers.sync();
        }
        run(step.plan, synthesis_pipelines_[w], [&](unsigned stage, std::uint32_t g) {
            if (is_active(synthesis_stages_[stage], g)) synthesize(synthesis_stages_[stage], step, g);
        });
    }
    if (w == 0) active_.held_level = level;
}

void PatchTransform::State::analyze(unsigned w, const Vec3f* positions, Vec3f* coefficients, Vec3f* second) {
    if (w == 0) active_.held_level = 0;
    for (unsigned j = levels_; j-- > 0;) {
        const Back step{tables_->plan(j), positions, coefficients, second};
        run(step.plan, analysis_pipelines_[w],
            [&](unsigned stage, std::uint32_t g) { analyze(analysis_stages_[stage], step, g); });
        workers.sync();
    }
    each_group(w, [&](std::uint32_t g) {
        store_vertices(tables_->plan(0), g, lifted(positions_, tables_->plan(0)), coefficients);
        if (second != nullptr) store_vertices(tables_->plan(0), g, lifted(second_, tables_->plan(0)), second);
    });
}

std::size_t PatchTransform::State::memory_bytes() const {
    std::size_t floats = normals_.size() + shapes_.size() + nothing_.size() + nowhere_.size() + keep_.size() +
                         3 * loop_specials_.size() + around_.first.size() + around_.next.size() + 2 * links_.size();
    for (const Field* field : {&positions_, &second_}) {
        floats += field->shares.size() + field->evens.size() + field->details.size() + 4 * field->listed.size();
        for (const auto& level : field->arrived) floats += level.size();
        for (const auto& level : field->lifted) floats += level.size();
    }
    std::size_t bytes = floats * sizeof(float);
    for (unsigned j = 0; j < levels_; ++j) bytes += tables_->plan(j).memory_bytes();
    return bytes;
}

namespace {

std::shared_ptr<const TransformTables> made_tables(const BaseMesh& base, unsigned levels,
                                                   const TransformOptions& options,
                                                   std::span<const std::uint8_t> creases) {
    auto tables = std::make_shared<TransformTables>(base, options, creases);
    tables->make_all(levels);
    return tables;
}

}  // namespace

PatchTransform::PatchTransform(std::shared_ptr<const TransformTables> tables, unsigned levels, unsigned threads,
                               bool updates)
    : state_(std::make_unique<State>(std::move(tables), levels, threads, updates)) {}
PatchTransform::PatchTransform(const BaseMesh& base, unsigned levels, const TransformOptions& options,
                               std::span<const std::uint8_t> creases, unsigned threads, bool updates)
    : PatchTransform(made_tables(base, levels, options, creases), levels, threads, updates) {}
PatchTransform::~PatchTransform() = default;
PatchTransform::PatchTransform(PatchTransform&&) noexcept = default;
PatchTransform& PatchTransform::operator=(PatchTransform&&) noexcept = default;

void PatchTransform::analyze(std::span<const Vec3f> positions, std::span<Vec3f> coefficients, std::span<Vec3f> second) {
    assert(positions.size() == coefficients.size() && positions.size() == state_->vertex_count(state_->levels()));
    state_->restrict_to_nothing();
    // Base vertices in no face, and a transform of no levels: as they are.
    std::copy_n(positions.begin(), state_->vertex_count(0), coefficients.begin());
    std::fill(second.begin(), second.end(), Vec3f{});
    if (state_->levels() == 0) return;
    state_->use_analysis_slots();
    state_->workers.run([&](unsigned w) {
        state_->analyze(w, positions.data(), coefficients.data(), second.empty() ? nullptr : second.data());
    });
}

void PatchTransform::synthesize(std::span<const Vec3f> coefficients, unsigned level, std::span<Vec3f> positions,
                                std::span<const Vec3f> second, std::span<Vec3f> second_out) {
    assert(level <= state_->levels() && positions.size() == state_->vertex_count(level));
    assert(second.empty() == second_out.empty());
    state_->restrict_to_nothing();
    std::copy_n(coefficients.begin(), state_->vertex_count(0), positions.begin());
    if (!second.empty()) std::copy_n(second.begin(), state_->vertex_count(0), second_out.begin());
    if (level == 0) return;
    state_->use_synthesis_slots();
    state_->workers.run([&](unsigned w) {
        state_->synthesize(w, coefficients.data(), second.empty() ? nullptr : second.data(), level, positions.data(),
                           second_out.data());
    });
}

void PatchTransform::update(std::span<const Vec3f> coefficients, std::span<const std::uint32_t> faces,
                            unsigned first_level, unsigned level, std::span<Vec3f> positions) {
    if (level == 0 || !state_->restrict_to(faces, first_level, level))
        return synthesize(coefficients, level, positions);
    state_->use_synthesis_slots();
    state_->workers.run(
        [&](unsigned w) { state_->synthesize(w, coefficients.data(), nullptr, level, positions.data(), nullptr); });
}

std::size_t PatchTransform::memory_bytes() const {
    return state_->memory_bytes();
}

}  // namespace mvw
