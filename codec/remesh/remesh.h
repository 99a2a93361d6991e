// From a clean triangle mesh to semi-regular parts over few base faces. Encoder only.
//
// Quadric-error edge collapses with a local joint flattening each give a bijection between base and input (successive
// self-parameterisation, Liu et al. 2020, 2021; MAPS, Lee et al. 1998); the base's dyadic points are mapped back
// through it onto the input surface.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/mesh/semi_regular.h"
#include "codec/remesh/features.h"

namespace mvw {

/// Called from the encoding thread with a phase ("decimate", "sample", ...) and its fraction done in [0, 1].
using Progress = std::function<void(const char* phase, double done)>;

/// So few vertices cost little: where no levels are asked for, a smooth part gets another one up to this.
inline constexpr double kFewVertices = 65'536;

struct RemeshOptions {
    unsigned base_faces = 0;       // all parts together; 0: chosen from the model
    int levels = -1;               // -1: chosen from the model
    double target_error = 0;       // RMS, fraction of the box's diagonal; 0: chosen from the model
    double feature_angle_deg = 0;  // from which on edges are features; 0: chosen from the model
    unsigned threads = 0;          // 0: all cores
    Progress progress;
};

/// How a part came about.
enum class PartOrigin : std::uint8_t {
    Alone,   // of 0 levels, as the input has it: coded by Draco alone
    Facets,  // few faces that no smaller base serves: they are the base, every edge a crease, one level of no detail
    Recognized,  // subdivision connectivity of its own, with its vertices
    Remeshed,
};

struct RemeshResult {
    /// Components of one origin that started with one level count share a part.
    std::vector<SemiRegularMesh> parts;
    std::vector<std::uint32_t> part_of_face;             // F: where each face of the input went
    std::vector<PartOrigin> origins;                     // of each part
    double alone_area_share = 0, facets_area_share = 0;  // of the surface, in parts of these origins
    double feature_angle_deg = kFeatureAngleDeg;         // from which on edges were features
};

/// input: manifold and oriented, no degenerate faces (clean.h), any number of components. Never fails: a component that
/// cannot be remeshed soundly keeps its faces, as facets or, where these are many, alone. Unless levels, base or error
/// are asked for, components that have subdivision connectivity of two levels or more, each base face within one
/// material, keep it and their vertices. Genus, components, boundary loops and materials are kept.
RemeshResult remesh(const Mesh& input, const RemeshOptions& options);

}  // namespace mvw
