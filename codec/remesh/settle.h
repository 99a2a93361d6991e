// The last step of laying a remesh: from vertices on the input to vertices that come as near to it as they can
// together.
#pragma once
#include <cstdint>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

struct SettleOptions {
    unsigned rounds = 1;  // of the fit
    bool again = false;   // another round where much was ironed; points that slide on start better without
    unsigned threads = 1;
};

/// Fits (fit.h), unfolds (unfold.h) and irons (iron.h), but for what ironing would take farther from the input's
/// vertices. input: the surface. triangles, fixed, normals (V), positions (V): as of these. Any thread count gives the
/// same.
void settle(const Mesh& input, const std::vector<Face>& triangles, const std::vector<std::uint8_t>& fixed,
            const std::vector<Vec3>& normals, const SettleOptions& options, std::vector<Vec3>& positions);

}  // namespace mvw
