// The stencils of listed edges in grid coordinates, found on explicit connectivity of a coarse level and carried over
// to finer ones: around a base vertex, and along a sharp side far from its ends, all fine levels look alike.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "codec/transform/lifting.h"
#include "codec/transform/patch/layout.h"

namespace mvw {

struct ListedStencils {
    struct Term {
        GridVertex vertex;
        double position, shape;  // for Vector, shape is what its second component takes from the positions
    };
    struct Lift {
        GridVertex vertex;
        double weight;
    };
    struct Edge {
        GridEdge edge;
        bool sharp;
        std::uint32_t last_term, last_lift;  // past its own, which begin where those of the edge before end
    };
    std::vector<Edge> edges;
    std::vector<Term> terms;
    std::vector<Lift> lifts;

    [[nodiscard]] std::span<const Term> terms_of(std::size_t e) const {
        const std::uint32_t first = e == 0 ? 0 : edges[e - 1].last_term;
        return std::span(terms).subspan(first, edges[e].last_term - first);
    }
    [[nodiscard]] std::span<const Lift> lifts_of(std::size_t e) const {
        const std::uint32_t first = e == 0 ? 0 : edges[e - 1].last_lift;
        return std::span(lifts).subspan(first, edges[e].last_lift - first);
    }
    /// The terms and lifts added since the last edge are this one's.
    void end_edge(const GridEdge& edge, bool sharp) {
        edges.push_back(
            {edge, sharp, static_cast<std::uint32_t>(terms.size()), static_cast<std::uint32_t>(lifts.size())});
    }
};

// From this level on (n = 8) stencils near a base vertex no longer see a second one. On the level before, those of an
// edge at a base vertex see of others only whether the one that it leads to is regular.
inline constexpr unsigned kFanLevel = 3, kSpokeLevel = 2;

/// Those of a level below kSpokeLevel, all of it made explicit. Names as make_level() gives them (not the owner's).
ListedStencils explicit_stencils(const BaseMesh& base, unsigned level, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases);

/// Those of finer levels: around each base vertex as in a fan of its valence and creases alone, one small mesh for each
/// kind of base vertex; along the middles of sharp sides as along one such side. On kSpokeLevel, where nothing near is
/// sharp, of each edge as in a fan with one neighbour that is regular or is not; the rest is made explicit there.
class CarriedStencils {
 public:
    CarriedStencils(const GridTopology& topology, const TransformOptions& options,
                    std::span<const std::uint8_t> creases);
    /// level: at least kSpokeLevel. Keeps small meshes' stencils: not for several threads at once.
    [[nodiscard]] ListedStencils at_level(unsigned level);

 private:
    struct Corner {
        std::uint32_t face;
        unsigned corner;
    };
    struct Fan {
        std::vector<Corner> corners;  // counter-clockwise; from the boundary on where there is one
        std::size_t kind;             // of kinds_
    };
    void add_fan(Corner start, std::vector<std::uint8_t>& seen);
    [[nodiscard]] Corner turned(Corner c, bool clockwise) const;
    [[nodiscard]] std::uint32_t hub(const Fan& fan) const;
    [[nodiscard]] bool is_smooth(const Fan& fan) const;
    void make_kinds();
    void add_spokes(const Fan& fan, ListedStencils& out);
    void add_corner(const Fan& fan, int n, ListedStencils& out) const;
    void add_middles(int n, ListedStencils& out) const;
    [[nodiscard]] ListedStencils at_spoke_level();

    const GridTopology& topology_;
    std::vector<std::uint8_t> sharp_;  // of each base edge
    TransformOptions options_;
    std::vector<Fan> fans_;
    std::vector<std::uint8_t> plain_;                    // of each base vertex: one fan, no sharp edge
    std::vector<std::uint32_t> valence_;                 // of each base vertex
    std::vector<std::vector<std::uint8_t>> signatures_;  // closed or not, then whether each spoke is sharp
    std::vector<ListedStencils> kinds_;                  // of the signatures; none before a fine level was asked for
    std::array<ListedStencils, 2> middles_;              // of a boundary, of a crease
    std::map<std::pair<std::size_t, bool>, ListedStencils>
        spokes_;  // by valence, and whether the spoke's end is regular
};

}  // namespace mvw
