// Distance between two surfaces, both ways, with exact closest points: the number that every claim here is made in.
#pragma once
#include <cstdint>

#include "codec/mesh/mesh.h"

namespace mvw {

struct SurfaceErrorOptions {
    std::uint32_t samples = 1'000'000;  // points laid on each surface by area, fixed seed; its vertices come on top
    unsigned threads = 0;               // 0: all cores
};

/// Distances as fractions of the diagonal of the reference's box.
struct SurfaceError {
    double rms = 0;         // the larger of both directions
    double mean = 0;        // the larger of both directions
    double max = 0;         // Hausdorff distance of the samples
    double psnr = 0;        // 20 log10(1 / rms), infinite where rms is 0
    double normal_deg = 0;  // mean angle between facet normals at corresponding points, the larger of both directions
};

/// Both meshes need a face of positive area (assert). Deterministic for given samples, whatever the thread count.
SurfaceError surface_error(const Mesh& reference, const Mesh& other, const SurfaceErrorOptions& options = {});

}  // namespace mvw
