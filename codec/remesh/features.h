// Finds the sharp edges of a surface and the borders between its materials: the curves that base edges shall follow.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

inline constexpr double kFeatureAngleDeg = 40;

struct FeatureOptions {
    double angle_deg = kFeatureAngleDeg;  // between the normals of an edge's faces
    double min_length = 0.02;             // of the diagonal: a shorter curve that ends freely is taken for noise
    double min_group = 0.1;               // of the diagonal: length of all curves that hang together
};

/// One flag for each half-edge (3 * face + side): 1 on both halves of an edge that lies on a feature curve, or between
/// two materials whatever the options say. Boundary edges have none. mesh: clean. O(F log F).
std::vector<std::uint8_t> feature_half_edges(const Mesh& mesh, const FeatureOptions& options = {});

}  // namespace mvw
