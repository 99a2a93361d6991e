// The machinery of PatchTransform: buffers, plans, and the phases of a level as loops over groups of patches.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "codec/transform/patch/floats.h"
#include "codec/transform/patch/kernels.h"
#include "codec/transform/patch/pipeline.h"
#include "codec/transform/patch/plan.h"
#include "codec/transform/transform.h"
#include "codec/workers.h"

namespace mvw {

/// A step is a row of stages (Stage). A stage of a group writes only what its patches hold, and reads of others what
/// the stage before left, which no one writes before all around have read it: so the result depends neither on the
/// number of threads nor on the order of groups (pipeline.h).
///
/// A vertex on a side or corner is computed by its one owner. While the lift runs, what a patch holds of vertices that
/// others own (its ghosts among them) is its own edges' share of their lift: the owner collects the shares, then all
/// copy the owner's result.
struct PatchTransform::State {
    State(std::shared_ptr<const TransformTables> tables, unsigned levels, unsigned threads, bool updates);

    // The whole transform as worker `w` sees it. `second`: as in PatchTransform, or null.
    void synthesize(unsigned w, const Vec3f* coefficients, const Vec3f* second, unsigned level, Vec3f* positions,
                    Vec3f* second_out);
    void analyze(unsigned w, const Vec3f* positions, Vec3f* coefficients, Vec3f* second);

    /// Before synthesize(): that only the details of these faces and of levels from first_level on differ from the last
    /// time. False where that cannot be used, and all is to be done.
    bool restrict_to(std::span<const std::uint32_t> faces, unsigned first_level, unsigned level);
    void restrict_to_nothing() { active_.all = true; }
    void use_synthesis_slots() { slots_ = &synthesis_slots_; }
    void use_analysis_slots() { slots_ = &analysis_slots_; }

    [[nodiscard]] unsigned levels() const { return levels_; }
    [[nodiscard]] std::size_t vertex_count(unsigned level) const {
        return static_cast<std::size_t>(vertices_at_level(topology_.base(), level));
    }
    [[nodiscard]] std::size_t memory_bytes() const;

    Workers workers;

 private:
    struct Weights {
        FloatWeights lift, position, shape;
    };
    /// One quantity that lives on the vertices: positions, or the vector transform's second component.
    struct Field {
        std::vector<Floats> arrived;  // vertices of each level before its step, where patches own them; lifted in place
        std::vector<Floats> lifted;   // updates only: apart, so that both are held
        Floats shares;                // updates only: the lift before it is known to be all there
        Floats evens;                 // Loop only: vertices after the even rule
        Floats details;               // of the groups at work (details_of)
        std::vector<ListedDetail> listed;  // details of listed edges while they lie apart
    };
    /// What lies across a side of a patch.
    struct Link {
        std::uint32_t patch = kNone;  // none on a boundary
        std::uint8_t side = 0;        // there
        bool owned = false;           // the side is this patch'
    };
    using Groups = std::vector<std::uint8_t>;  // a flag for each; empty: all
    /// What an update touches, by groups: sets grow around what differs, and shrink to where bits changed from step to
    /// step.
    struct Active {
        bool all = true;
        unsigned first_level = 0;         // of the details that differ
        unsigned held_level = 0;          // of the last synthesis: its arrived and lifted vertices are there
        Groups details, arrived, handed;  // differ: details as given, vertices of this step, those of the next
        Groups lift, shares, estimate;    // to be lifted; whose edges have a share in that, and are predicted; around
    };

    // Phases (patch_phases.cpp), for patch f of the step that `plan` describes.
    void copy_ghosts(const LevelPlan& plan, std::uint32_t f, const float* from, float* to) const;
    void collect(const LevelPlan& plan, std::uint32_t f, float* v) const;
    void fold_boundary(const LevelPlan& plan, std::uint32_t f, float* v) const;
    void corner_normals(const LevelPlan& plan, std::uint32_t f, const float* v);
    void corner_shapes(const LevelPlan& plan, std::uint32_t f, const float* v);
    void set_sharp_shapes(const LevelPlan& plan, std::uint32_t f, const float* v);
    void hide_listed(const LevelPlan& plan, std::uint32_t f, Field& field) const;
    void show_listed(const LevelPlan& plan, std::uint32_t f, Field& field) const;
    void zero_foreign(const LevelPlan& plan, std::uint32_t f, Field& field) const;
    void predict_listed(const LevelPlan& plan, std::uint32_t f, const float* v, float sign);
    void predict_second_listed(const LevelPlan& plan, std::uint32_t f, const float* v, float sign);
    void loop_specials(const LevelPlan& plan, std::uint32_t f, bool inverse, const float* v);
    void put_loop_specials(const LevelPlan& plan, std::uint32_t f, float* v) const;
    // The same for whole groups.
    void find_normals(const LevelPlan& plan, std::uint32_t g, float* v);
    void find_shapes(const LevelPlan& plan, std::uint32_t g, const float* v);
    void lift(const LevelPlan& plan, std::uint32_t g, Field& field, float sign, const float* in, float* out);
    void predict(const LevelPlan& plan, std::uint32_t g, const float* v, float sign);
    void predict_second(const LevelPlan& plan, std::uint32_t g, const float* v, float* x, float sign);
    void loop_even(const LevelPlan& plan, std::uint32_t g, bool inverse, const float* in, float* out);

    // Between hierarchical arrays and groups (patch_io.cpp).
    void load_details(const LevelPlan& plan, std::uint32_t g, const Vec3f* from, Field& field) const;
    void store_details(const LevelPlan& plan, std::uint32_t g, Field& field, Vec3f* to);
    void load_vertices(const LevelPlan& plan, std::uint32_t g, const Vec3f* from, float* v) const;
    void store_vertices(const LevelPlan& plan, std::uint32_t g, const float* v, Vec3f* to);
    template <typename Float>
    using Runs = std::array<Float*, 16>;  // by lane
    template <typename Float, typename Vec>
    Runs<Float> face_runs(unsigned level, std::uint32_t g, Vec* array) const;
    template <typename Float, typename Vec>
    Runs<Float> side_runs(unsigned level, std::uint32_t g, unsigned s, Vec* array, Float* others) const;
    template <typename Visit>
    void visit_corners(const LevelPlan& plan, std::uint32_t g, Visit visit) const;
    /// Where group g may write what no one reads, a side's worth.
    [[nodiscard]] float* nowhere(std::uint32_t g) { return nowhere_.data() + g * nothing_.size(); }

    // Stages of a step (patch_transform.cpp), in this order; which of them run depends on the transform. Each needs the
    // one before of the groups around.
    enum Stage : std::uint8_t {
        Load,
        Normals,
        Turn,
        Lift,
        Collect,
        Corners,
        Estimate,
        Predict,
        LoopEven,
        LoopCollect,
        Store
    };
    /// What a step works on. Arrays in hierarchical order, as in PatchTransform.
    struct Step {
        const LevelPlan& plan;
        const Vec3f *coefficients, *second;  // synthesis: in
        Vec3f *positions, *second_out;       // synthesis: out, of the last step; null of others
    };
    struct Back {
        const LevelPlan& plan;
        const Vec3f* positions;
        Vec3f *coefficients, *second;  // out
    };
    void synthesize(Stage stage, const Step& step, std::uint32_t g);
    void analyze(Stage stage, const Back& step, std::uint32_t g);
    void lift_forward(const LevelPlan& plan, std::uint32_t g, Field& field, const Vec3f* coefficients);
    void collect_lift(const LevelPlan& plan, std::uint32_t g, Field& field, float sign);
    void find_corners(const LevelPlan& plan, std::uint32_t g, const float* v);
    void estimate(const LevelPlan& plan, std::uint32_t g, float* v);
    void predict_all(const Step& step, std::uint32_t g);
    void unpredict_all(const Back& step, std::uint32_t g);
    void hand_over(const LevelPlan& plan, std::uint32_t g, Field& field, const float* v, Vec3f* out);
    void take_over(const LevelPlan& plan, std::uint32_t g, Field& field, const Vec3f* from);
    void turn_details(const LevelPlan& plan, std::uint32_t g, bool to_model, const float* from, float* v);
    void loop_shares(const LevelPlan& plan, std::uint32_t g, bool inverse, const float* in, float* out);
    void loop_collect(const LevelPlan& plan, std::uint32_t g, float* v);
    void choose_active(const LevelPlan& plan);
    [[nodiscard]] bool is_active(Stage stage, std::uint32_t g) const;
    void grow(const LevelPlan& plan, const Groups& from, Groups& to) const;
    void grow_once(const Groups& from, Groups& to) const;
    // From this level on (n = 4) no stencil of a patch sees a vertex that a patch apart from it owns.
    static constexpr unsigned kNearLevel = 2;
    template <typename Work>
    void run(const LevelPlan& plan, const Pipeline& pipeline, Work work) {
        const auto sync = [this] { workers.sync(); };
        if (plan.level < kNearLevel)
            pipeline.run_in_phases(work, sync);
        else
            pipeline.run(work, sync);
    }

    template <typename Work>
    void each_patch(std::uint32_t g, Work work) const {
        for (std::uint32_t f = g * lanes_; f < g * lanes_ + used(g); ++f) work(f);
    }
    template <typename Work>
    void each_group(unsigned w, Work work) const {
        const auto [begin, end] = share(w);
        for (std::uint32_t g = begin; g < end; ++g) work(g);
    }
    /// The base vertices that patch f owns.
    template <typename Work>
    void each_corner(const LevelPlan& plan, std::uint32_t f, Work work) const {
        for (unsigned c = 0; c < 3; ++c) {
            const std::uint32_t b = topology_.base().faces()[f][c];
            if (topology_.corner_owner(b) == std::pair(f, c)) work(b, plan.corners[b]);
        }
    }
    [[nodiscard]] unsigned used(std::uint32_t g) const { return std::min(lanes_, faces() - g * lanes_); }
    /// The groups of worker w.
    [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> share(unsigned w) const {
        const auto cut = [&](unsigned i) { return std::uint32_t(std::uint64_t{groups_} * i / workers.count()); };
        return {cut(w), cut(w + 1)};
    }
    [[nodiscard]] bool finds_shapes() const { return seeded_ || options_.kind == TransformKind::Vector; }
    [[nodiscard]] std::uint32_t faces() const { return topology_.base().face_count(); }
    [[nodiscard]] bool sharp(std::uint32_t f, unsigned s) const { return sharp_[std::size_t{3} * f + s] != 0; }
    [[nodiscard]] const Kernels& kernels() const { return kernels_; }
    [[nodiscard]] const Link& link(std::uint32_t f, unsigned s) const { return links_[std::size_t{3} * f + s]; }
    [[nodiscard]] static std::size_t vertices_of(const LevelPlan& plan, std::uint32_t g) {
        return std::size_t{g} * plan.layout.vertex_floats;
    }
    /// The group's details: in slots where groups go through all stages one soon after the other.
    [[nodiscard]] float* details_of(Field& field, const LevelPlan& plan, std::uint32_t g) const {
        const std::uint32_t slot = plan.level < kNearLevel ? g : (*slots_)[g];
        return field.details.data() + std::size_t{slot} * plan.layout.edge_floats;
    }
    [[nodiscard]] static float* lifted(Field& field, const LevelPlan& plan) {
        return (field.lifted.empty() ? field.arrived : field.lifted)[plan.level].data();
    }
    /// Where the lift goes first: in an update apart from what is held of the last time.
    [[nodiscard]] float* lifting(Field& field, const LevelPlan& plan) const {
        return active_.all ? lifted(field, plan) : field.shares.data();
    }
    void make_field(Field& field, bool updates, std::uint32_t slots) const;
    void find_groups_around();
    void choose_stages();
    [[nodiscard]] std::uint32_t place_in_slots(const std::vector<Pipeline>& pipelines,
                                               std::vector<std::uint32_t>& slots) const;

    const std::shared_ptr<const TransformTables> tables_;
    const GridTopology& topology_;
    unsigned levels_, lanes_;
    std::uint32_t groups_;
    const Kernels& kernels_;
    std::vector<Link> links_;  // 3 F, by patch
    const TransformOptions options_;
    PredictRule rule_;
    bool lazy_, seeded_, projected_;
    Weights weights_;
    std::vector<std::uint8_t> sharp_;  // 3 F: side runs along a boundary or crease
    std::vector<std::uint32_t> keep_;  // kKeepCount masks for each group
    Field positions_, second_;
    Floats normals_, shapes_;
    Floats nothing_, nowhere_;  // stand in for the sides that others own: zeros; for writing, apart for each group
    std::vector<Vec3f> corner_normals_, corner_shapes_, loop_specials_;
    GroupGraph around_;
    std::vector<Stage> synthesis_stages_, analysis_stages_;
    std::vector<Pipeline> synthesis_pipelines_, analysis_pipelines_;  // by worker
    std::vector<std::uint32_t> synthesis_slots_, analysis_slots_;     // by group
    const std::vector<std::uint32_t>* slots_ = nullptr;               // of the two, while that runs
    Active active_;
};

}  // namespace mvw
