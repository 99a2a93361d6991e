// The regular rules over one group of patches, vectorised (Google Highway, the best instruction set chosen at run time,
// its portable code elsewhere). Every stencil is a set of constant offsets within rows, or a list of them near a
// patch's sides; weights come as tables.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/transform/patch/layout.h"
#include "codec/transform/stencils.h"
#include "codec/vec.h"

namespace mvw {

struct FloatWeights {
    float ends = 0, opp = 0, wings = 0, far = 0;

    FloatWeights() = default;
    explicit FloatWeights(const TenWeights& w)
        : ends(float(w.ends)), opp(float(w.opp)), wings(float(w.wings)), far(float(w.far)) {}
};

/// Which lanes of a group keep their value at a kind of point, as masks of `lanes` words each, all or no bits: those
/// that own side 0, 1, 2, then corner 0, 1, 2; all; none.
enum Keep : std::uint8_t { kKeepSide = 0, kKeepCorner = 3, kKeepAll = 6, kKeepNone = 7, kKeepCount = 8 };

/// The vertices that the edges of a patch lift, ghosts among them, and those edges by class. Vertices two rows and more
/// inside are not here: their thirty edges lie at constant offsets.
struct LiftProgram {
    struct Point {
        std::uint32_t vertex;
        Keep keep;
        std::array<std::uint8_t, 4> count;  // edges that have the vertex as end, opposite, wing, far point
    };
    std::vector<Point> points;
    std::vector<std::uint32_t> edges;  // offsets, class by class, point by point
};
LiftProgram make_lift_program(const Layout& layout);

/// Offsets of the same point in two patches.
struct Copy {
    std::uint32_t to, from;
};

/// An edge whose stencils are lists: it touches a base vertex, or a boundary or crease. Its detail lies apart while the
/// lift and the prediction run. The vertices of its prediction follow those of the edge before, its ends first where it
/// is `projected`.
struct ListedEdge {
    std::uint32_t edge;           // offset of its detail within the owner's group
    std::uint32_t last_vertex;    // of the plan's listed_vertices
    std::uint32_t weights : 31;   // where they begin; edges of one kind share them
    std::uint32_t projected : 1;  // SeededNormal speaks along the normal here
};
/// A vertex that listed edges lift. Its sources, listed edges, follow those of the target before.
struct LiftTarget {
    std::uint32_t vertex;
    std::uint32_t last_source;
    std::uint32_t weights;  // where they begin; targets of one kind share them
};
/// The detail of a listed edge, as wide as a vector.
struct alignas(16) ListedDetail {
    float x = 0, y = 0, z = 0, unused = 0;
};
/// Where the lists of a patch are: its edges or targets, from whose first vertex or source on.
struct ListedEdges {
    std::span<const ListedEdge> edges;
    const std::uint32_t* vertices;
    std::uint32_t first_vertex;
    const float* weights;  // in turn: what a vertex' position counts for, and its shape component
};
struct LiftTargets {
    std::span<const LiftTarget> targets;
    const std::uint32_t* sources;
    std::uint32_t first_source;
    const float* weights;
};

/// Pointers are to one group. Ghosts of vertices that a kernel reads must be filled. Listed edges, base vertices and
/// what the patch does not own come out wrong: lists and copies put that right.
struct Kernels {
    /// out = scale in + sum of w d over the patch' own edges, where the lane keeps its value; the sum alone elsewhere.
    void (*lift)(const Layout&, const LiftProgram&, const FloatWeights& w, float scale, const std::uint32_t* keep,
                 const float* d, const float* in, float* out);
    /// d += sign * P(v), P the ten points with `position`; with `shape` not null also the ten of x with
    /// `shape_weights`.
    void (*predict)(const Layout&, const FloatWeights& position, const FloatWeights& shape_weights, float sign,
                    const float* v, const float* shape, float* d);
    /// The same along the normal only: P = m + n n.(Q - m).
    void (*predict_along_normal)(const Layout&, const FloatWeights& position, const FloatWeights& shape_weights,
                                 float sign, const float* v, const float* shape, const float* normals, float* d);
    /// Unit vertex normals; zero where they cancel.
    void (*normals)(const Layout&, const float* v, float* normals);
    /// x = (v - mean of ring)/4; with `normals` not null, its part along them.
    void (*shape)(const Layout&, const float* v, const float* normals, float* x);
    /// Details from local frames to model axes, or back.
    void (*turn)(const Layout&, bool to_model, const float* v, const float* normals, float* d);
    /// Vertices of the next level from those of this one and the points on its edges; whether any bit of fine_v
    /// changed. And back.
    bool (*interleave)(const Layout& coarse, const float* v, const float* d, const Layout& fine, float* fine_v);
    void (*deinterleave)(const Layout& fine, const float* fine_v, const Layout& coarse, float* v, float* d);
    /// A run of points in each patch' own array to places in the group, and back. places: of each float of a run, in
    /// order; runs: where each lane's run starts, `used` lanes. follow: the next group's runs come right behind these.
    void (*load_runs)(const std::vector<std::uint32_t>& places, const float* const* runs, unsigned used, bool follow,
                      float* to);
    void (*store_runs)(const std::vector<std::uint32_t>& places, float* const* runs, unsigned used, bool follow,
                       const float* from);

    // Single points of one lane; pointers are to the lane.
    /// to[c.to] = from[c.from] of each copy, all three components; to[c.from] += from[c.to].
    void (*copy)(std::span<const Copy> copies, const float* from, float* to);
    void (*add_back)(std::span<const Copy> copies, const float* from, float* to);
    /// v[c.from] += v[c.to] of some of the copies.
    void (*add_back_some)(std::span<const std::uint32_t> which, const Copy* copies, float* v);
    /// Zeroes points.
    void (*clear_points)(std::span<const std::uint32_t> places, float* to);
    /// Listed edges; pointers are to all groups. v += sign * sum of w d.
    void (*lift_listed)(const LiftTargets& lists, const ListedDetail* listed, float sign, float* v);
    /// Each d += sign * P(v, shape), along the normal alone where so; `shape` and `normals` may be null.
    void (*predict_listed)(const ListedEdges& lists, float sign, const float* v, const float* shape,
                           const float* normals, ListedDetail* listed);
};

/// For this machine and groups of so many lanes (16, 8, 4 or 1; in WebAssembly 8 or 1).
const Kernels& kernels(unsigned lanes);

/// Lanes of the groups that a base of so many faces is cut into: as wide as the machine's vectors where idle lanes cost
/// little memory.
unsigned lanes_for(std::uint32_t faces);

}  // namespace mvw
