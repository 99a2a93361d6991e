// From which angle on edges are features: scans have faint edges by chance, machined parts have them on purpose.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/remesh/features.h"

namespace mvw {

struct ChosenFeatures {
    std::vector<std::uint8_t> sharp;      // as of feature_half_edges(), from ...
    double angle_deg = kFeatureAngleDeg;  // ... so much on
};

ChosenFeatures features_from(const Mesh& mesh, double angle_deg);

/// Whether both sides are flat along half of all edges' length, as on machined parts. mesh: clean.
bool is_machined(const Mesh& mesh);

/// The usual features; on machined parts those of the least of some angles that does not make the base half as large
/// again. mesh: clean. base_faces: how many a decimation ends with that has to follow these half-edges.
ChosenFeatures choose_features(const Mesh& mesh,
                               const std::function<std::size_t(const std::vector<std::uint8_t>& sharp)>& base_faces);

}  // namespace mvw
