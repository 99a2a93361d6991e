// What a transform works out beforehand about a base mesh, level by level. Whoever decodes to finer and finer levels
// keeps it, and has what is missing made by several threads.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codec/mesh/semi_regular.h"
#include "codec/transform/transform.h"

namespace mvw {

class CarriedStencils;
class GridTopology;
struct LevelPlan;

/// The tables of all transforms of one base with the same options, of whatever number of levels. No transform that uses
/// them may be at work while some are added; it goes on with them afterwards.
class TransformTables {
 public:
    /// creases: as for PatchTransform.
    TransformTables(const BaseMesh& base, const TransformOptions& options, std::span<const std::uint8_t> creases);
    ~TransformTables();

    /// How many jobs there are to do until a transform of so many levels can use these tables: a new list.
    [[nodiscard]] std::size_t jobs(unsigned levels);
    /// Does one of the last list, each once; several threads may do one each.
    void make(std::size_t job);
    /// Does all that a transform of so many levels needs.
    void make_all(unsigned levels);

    [[nodiscard]] const TransformOptions& options() const { return options_; }
    [[nodiscard]] std::span<const std::uint8_t> creases() const { return creases_; }
    [[nodiscard]] const GridTopology& topology() const { return *topology_; }
    /// Of the step from level j to j + 1, which has been made.
    [[nodiscard]] const LevelPlan& plan(unsigned j) const { return *plans_[j]; }

 private:
    std::unique_ptr<const GridTopology> topology_;
    const TransformOptions options_;
    const std::vector<std::uint8_t> creases_;
    std::unique_ptr<CarriedStencils> carried_;       // of levels from 2 on; null before the first one
    std::vector<std::unique_ptr<LevelPlan>> plans_;  // by level
    std::vector<unsigned> jobs_;                     // levels to make; from 3 on the first one stands for all below levels_
    unsigned levels_ = 0;                            // that the jobs are for
};

}  // namespace mvw
