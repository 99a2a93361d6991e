// The stencils of listed edges in grid coordinates, found on explicit connectivity of a coarse level and carried over
// to finer ones: around a base vertex, and along a sharp side far from its ends, all fine levels look alike.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
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

/// Those of any level, all of it made explicit: for levels below kSpokeLevel. Names as make_level() gives them (not the
/// owner's).
ListedStencils explicit_stencils(const BaseMesh& base, unsigned level, const TransformOptions& options,
                                 std::span<const std::uint8_t> creases);

struct FaceCorner {
    std::uint32_t face;
    unsigned corner;
};

/// Those of finer levels, found on small meshes.
class CarriedStencils {
 public:
    CarriedStencils(const GridTopology& topology, const TransformOptions& options,
                    std::span<const std::uint8_t> creases);
    /// Of kSpokeLevel. Where nothing near is sharp each edge is looked up by its base vertex' valence and whether the
    /// one that it leads to is regular; the rest of the level is made explicit.
    [[nodiscard]] ListedStencils at_spoke_level() const;
    /// Of kFanLevel or a finer one: around each base vertex as in a fan of its valence and creases alone, one small
    /// mesh for each kind of base vertex (where nothing is sharp, the one of kSpokeLevel whose spoke leads to a regular
    /// vertex: from here that looks like the inside of a face); along the middles of sharp sides as along one such
    /// side. Keeps small meshes' stencils: not for several threads at once, but beside at_spoke_level().
    [[nodiscard]] ListedStencils at_level(unsigned level);

 private:
    struct Fan {
        std::vector<FaceCorner> corners;  // counter-clockwise; from the boundary on where there is one
        bool closed;
    };
    [[nodiscard]] const ListedStencils& spoke(std::size_t spokes, bool regular) const;
    [[nodiscard]] ListedStencils smooth_fan(std::size_t spokes) const;
    class Spokes;
    void add_fan(FaceCorner start, std::vector<std::uint8_t>& seen);
    [[nodiscard]] FaceCorner turned(FaceCorner c, bool clockwise) const;
    [[nodiscard]] std::uint32_t hub(const Fan& fan) const;
    [[nodiscard]] std::vector<float> signature(const Fan& fan) const;
    void make_kinds();
    void add_corner(std::size_t fan, int n, ListedStencils& out) const;
    void add_middles(int n, ListedStencils& out) const;

    const GridTopology& topology_;
    std::vector<std::uint8_t> sharp_;  // of each base edge
    TransformOptions options_;
    std::vector<Fan> fans_;
    // Of closed fans' spokes on kSpokeLevel, by their number and whether they lead to a regular vertex: found when
    // first asked for, by one thread at a time.
    mutable std::map<std::pair<std::size_t, bool>, std::shared_ptr<const ListedStencils>> spokes_;
    mutable std::mutex finding_spoke_;
    std::vector<std::size_t> kind_of_fan_;  // of kinds_; both empty before a level from kFanLevel on was asked for
    std::vector<ListedStencils> kinds_;
    std::array<ListedStencils, 2> middles_;  // of a boundary, of a crease
};

}  // namespace mvw
