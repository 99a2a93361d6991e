// The stencils of listed edges in grid coordinates, found on explicit connectivity of a coarse level and carried over
// to finer ones: around a base vertex, and along a sharp side far from its ends, all fine levels look alike.
#pragma once
#include <vector>

#include "codec/transform/lifting.h"
#include "codec/transform/patch/layout.h"

namespace mvw {

struct ListedStencil {
    struct Term {
        GridVertex vertex;
        double position, shape;
    };
    struct Lift {
        GridVertex vertex;
        double weight;
    };
    GridEdge edge;
    std::array<GridVertex, 2> ends;
    bool sharp;
    std::vector<Term> terms;
    std::vector<Lift> lifts;
};
/// An ordinary edge that lifts a base vertex.
struct CornerLift {
    std::uint32_t base_vertex;
    GridEdge edge;
    double weight;
};
struct ListedStencils {
    std::vector<ListedStencil> edges;
    std::vector<CornerLift> corner_lifts;
};

// From this level on (n = 8) stencils near base vertices no longer see a second base vertex.
inline constexpr unsigned kExplicitLevels = 3;

/// All of level <= kExplicitLevels, names as make_level() gives them (not the owner's).
ListedStencils explicit_stencils(const BaseMesh& base, unsigned level, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases);

/// Those of `explicit_at` (of level kExplicitLevels) carried to a finer level, and those of the sharp sides' middles.
ListedStencils carried_stencils(const GridTopology& topology, const ListedStencils& explicit_at, unsigned level,
                                const TransformOptions& options, std::span<const std::uint8_t> creases);

}  // namespace mvw
