// Decimates a mesh to a base and remembers a bijection between the two surfaces: each collapse flattens its
// surroundings into one planar domain before and after, and a point goes down or up through those domains
// (Liu et al. 2020, 2021; the idea of MAPS, Lee et al. 1998).
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"
#include "codec/remesh/collapse_mesh.h"
#include "codec/remesh/flatten.h"
#include "codec/remesh/quadric.h"

namespace mvw {

class Crossings;

/// A point on a triangle mesh: a face and barycentric weights over its corners, which sum to 1.
struct FacePoint {
    std::uint32_t face = 0;
    std::array<double, 3> weight{1, 0, 0};
};

/// What a decimation is allowed to do.
struct DecimateOptions {
    std::size_t target_faces = 0;  // 0: decimate to at most max_faces, and further until the error is reached
    std::size_t max_faces = 0;
    double error = 0;            // RMS distance to the input as the quadrics estimate it, model units
    double corner_reach = 0;     // how far a line is looked at for corners, model units
    double shape_weight = 1e-4;  // of edge length squared times area, against the quadric error
    std::function<void(double)> progress;
};

/// The history of one decimation.
class SelfParameterization {
 public:
    /// mesh: clean. sharp: empty, or a flag a half-edge (3 * face + side). Decimates as far as the options say, or
    /// until nothing sound is left to collapse.
    SelfParameterization(const Mesh& mesh, const std::vector<std::uint8_t>& sharp, const DecimateOptions& options);

    /// What is left after the decimation; its live faces are the base.
    [[nodiscard]] const CollapseMesh& base() const { return mesh_; }

    /// Maps points of the base (face: a live face of base()) onto the input, in place. Any thread count gives the same.
    void to_input(std::vector<FacePoint>& points, unsigned threads) const;

 private:
    struct Candidate;
    struct Collapse;
    struct Strictness;
    /// One collapse: slices of uv_ and faces_.
    struct Record {
        std::uint32_t uv_begin, face_begin;
        std::uint16_t ring_vertices, ring_faces;
        std::uint8_t edge_faces;
        bool stays;  // the new vertex is the kept one, in the chart too
    };
    /// A face of a record: ring faces first (center as in RingFace), then the edge's own faces, for which center tells
    /// which end its slot holds and apex the ring position of the third corner.
    struct RecordFace {
        std::uint32_t face;
        std::uint16_t apex;
        std::uint8_t slot, center;
    };

    void init_quadrics();
    [[nodiscard]] bool evaluate(std::uint32_t h, Candidate& out) const;
    [[nodiscard]] bool reached(const DecimateOptions& options) const;
    void sweep(const DecimateOptions& options);
    [[nodiscard]] Collapse prepare(const Candidate& c);
    [[nodiscard]] double cost_of_tips(const Candidate& c);
    [[nodiscard]] bool try_collapse(const Candidate& c, const Strictness& rules, Crossings* crossings);
    [[nodiscard]] bool keeps_shape(const Vec3& position, const Strictness& rules) const;
    void record(CollapseMode mode);
    void to_input_serial(std::span<FacePoint> points) const;
    void relocate(const Record& r, std::size_t ring_face, FacePoint& p) const;

    CollapseMesh mesh_;
    std::vector<Quadric> quadrics_;
    std::vector<std::uint32_t> version_;  // of each vertex: rises when it is an end of an edge that collapses
    double shape_weight_ = 0;
    double area_ = 0;           // of the input
    double squared_error_ = 0;  // of the decimated surface against the input, integrated over the area, by the quadrics
    EdgeRing ring_;
    std::vector<Uv> chart_;

    std::vector<Record> records_;
    std::vector<Uv> uv_;
    std::vector<RecordFace> faces_;
};

}  // namespace mvw
