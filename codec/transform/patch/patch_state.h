// The machinery of PatchTransform: buffers, plans, and the phases of a level as loops over patches.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "codec/transform/patch/kernels.h"
#include "codec/transform/patch/plan.h"
#include "codec/transform/patch/workers.h"
#include "codec/transform/transform.h"

namespace mvw {

/// Each phase touches only what its patch owns (and the patch's own ghosts), and reads of others only what no one
/// writes in that phase: so the result does not depend on the number of threads. Between phases the workers wait for
/// each other.
struct PatchTransform::State {
    State(const BaseMesh& base, unsigned levels, const TransformOptions& options, std::span<const std::uint8_t> creases,
          unsigned threads);

    /// The whole transform as worker `w` sees it.
    void synthesize(unsigned w, std::span<const Vec3f> coefficients, unsigned level, std::span<Vec3f> positions);
    void analyze(unsigned w, std::span<const Vec3f> positions, std::span<Vec3f> coefficients);

    [[nodiscard]] unsigned levels() const { return levels_; }
    [[nodiscard]] std::size_t vertex_count(unsigned level) const {
        return static_cast<std::size_t>(vertices_at_level(topology_.base(), level));
    }

    Workers workers;

 private:
    struct Weights {
        FloatWeights lift, position, shape;
    };
    struct Scratch {
        std::vector<Vec3f> points;
    };

    // Phases (patch_phases.cpp), for patch f of the step that `plan` describes.
    void sync_vertices(const LevelPlan& plan, std::uint32_t f, float* planes) const;
    void fold_boundary(const LevelPlan& plan, std::uint32_t f, float* v) const;
    void sync_edges(const LevelPlan& plan, std::uint32_t f);
    void zero_ghosts(const LevelPlan& plan, std::uint32_t f);
    void corner_normals(const LevelPlan& plan, std::uint32_t begin, std::uint32_t end);
    void corner_shapes(const LevelPlan& plan, std::uint32_t begin, std::uint32_t end);
    void find_normals(const LevelPlan& plan, std::uint32_t f);
    void find_shapes(const LevelPlan& plan, std::uint32_t f);
    void lift(const LevelPlan& plan, std::uint32_t f, float sign);
    void predict(const LevelPlan& plan, std::uint32_t f, float sign);
    void predict_listed(const LevelPlan& plan, std::uint32_t f, float sign);
    void loop_even(const LevelPlan& plan, std::uint32_t f, bool inverse, Scratch& scratch);
    void hide_listed(const LevelPlan& plan, std::uint32_t f);
    void show_listed(const LevelPlan& plan, std::uint32_t f);
    // Between hierarchical arrays and planes (patch_io.cpp).
    void load_details(const LevelPlan& plan, std::uint32_t f, const Vec3f* from);
    void store_details(const LevelPlan& plan, std::uint32_t f, Vec3f* to) const;
    void load_vertices(const LevelPlan& plan, std::uint32_t f, const Vec3f* from);
    void store_vertices(const LevelPlan& plan, std::uint32_t f, Vec3f* to) const;
    template <typename Visit>
    void visit_vertices(const LevelPlan& plan, std::uint32_t f, Visit visit) const;
    template <typename Visit>
    void visit_side_details(const LevelPlan& plan, std::uint32_t f, Visit visit) const;

    // Steps (patch_transform.cpp).
    void estimate(unsigned w, const LevelPlan& plan);
    void hand_over(const LevelPlan& plan, std::uint32_t f, bool last, Vec3f* positions);
    void synthesis_step(unsigned w, const LevelPlan& plan, const Vec3f* coefficients, bool last, Vec3f* positions);
    void analysis_step(unsigned w, const LevelPlan& plan, const Vec3f* positions, bool first, Vec3f* coefficients);

    template <typename Work>
    void each_patch(unsigned w, Work work) const {
        const auto [begin, end] = share(w, topology_.base().face_count());
        for (std::uint32_t f = begin; f < end; ++f) work(f);
    }
    [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> share(unsigned w, std::uint32_t count) const {
        const auto cut = [&](unsigned i) { return std::uint32_t(std::uint64_t{count} * i / workers.count()); };
        return {cut(w), cut(w + 1)};
    }
    [[nodiscard]] std::uint32_t faces() const { return topology_.base().face_count(); }
    [[nodiscard]] bool sharp(std::uint32_t f, unsigned s) const { return sharp_[std::size_t{3} * f + s] != 0; }
    // Levels take turns in the two vertex buffers, the finest in the first.
    [[nodiscard]] float* vertices(unsigned level) { return vertices_[(levels_ - 1 - level) % 2].data(); }
    [[nodiscard]] const float* vertices(unsigned level) const { return vertices_[(levels_ - 1 - level) % 2].data(); }

    GridTopology topology_;
    unsigned levels_;
    TransformOptions options_;
    PredictRule rule_;
    bool lazy_, seeded_, projected_;
    Weights weights_;
    std::vector<std::uint8_t> sharp_;  // 3 F: side runs along a boundary or crease
    std::vector<LevelPlan> plans_;
    std::array<std::vector<float>, 2> vertices_;
    std::vector<float> details_, normals_, shapes_;
    std::vector<Vec3f> corner_normals_, corner_shapes_;
    std::vector<Scratch> scratch_;  // by worker
};

}  // namespace mvw
