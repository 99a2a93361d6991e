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

namespace mvw {

/// Called from the encoding thread with a phase ("decimate", "sample", ...) and its fraction done in [0, 1].
using Progress = std::function<void(const char* phase, double done)>;

struct RemeshOptions {
    unsigned base_faces = 0;  // all parts together; 0: chosen from the model
    int levels = -1;          // -1: chosen from the model
    double target_error = 0;  // RMS, fraction of the box's diagonal; 0: chosen from the model
    unsigned threads = 0;     // 0: all cores
    Progress progress;
};

struct RemeshResult {
    /// Components that started with one level count share a part. A part of 0 levels is coded by Draco alone.
    std::vector<SemiRegularMesh> parts;
    std::vector<std::uint32_t> part_of_face;  // F: where each face of the input went
    std::vector<std::uint8_t>
        own_vertices;             // of each part: 1 where its vertices are the input's, which was semi-regular
    double alone_area_share = 0;  // of the surface in parts of 0 levels
};

/// input: manifold and oriented, no degenerate faces (clean.h), any number of components. Never fails: a component that
/// cannot be remeshed soundly becomes part of the part of 0 levels. Unless levels, base or error are asked for,
/// components that have subdivision connectivity of two levels or more keep it and their vertices. Genus, components
/// and boundary loops are kept.
RemeshResult remesh(const Mesh& input, const RemeshOptions& options);

}  // namespace mvw
