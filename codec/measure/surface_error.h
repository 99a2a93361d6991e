// Distance between two surfaces, both ways, with exact closest points: the number that every claim here is made in.
// (What Metro does: Cignoni, Rocchini, Scopigno, Metro: measuring error on simplified surfaces, 1998.)
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "codec/measure/surface_index.h"
#include "codec/mesh/mesh.h"

namespace mvw {

struct SurfaceErrorOptions {
    std::uint32_t samples = 1'000'000;  // points laid on each surface by area, fixed seed
    unsigned threads = 0;               // 0: all cores
    std::uint32_t vertex_stride = 1;    // every so many-th of each surface's positions is a point, too; at least 1
};

/// Fewer samples, at most as many as by default, and as many fewer vertices: so that figures agree with the default's.
inline SurfaceErrorOptions sampled(std::uint32_t samples, unsigned threads) {
    return {samples, threads, SurfaceErrorOptions{}.samples / samples};
}

/// Distances as fractions of the diagonal of the reference's box. All points count alike, and vertices at one position
/// once.
struct SurfaceError {
    double rms = 0;         // the larger of both directions
    double mean = 0;        // the larger of both directions
    double max = 0;         // Hausdorff distance of the samples
    double psnr = 0;        // 20 log10(1 / rms), infinite where rms is 0
    double normal_deg = 0;  // mean angle between facet normals at corresponding points, the larger of both directions
};

/// Whether mesh has a face of positive area and a finite box: what surface_error() asks of both meshes.
bool measurable(const Mesh& mesh);

/// A surface that others are measured against, and an index of it.
class ReferenceSurface {
 public:
    /// mesh: measurable() (assert), copied. threads: to build the index, 0: all cores. O(F log F).
    explicit ReferenceSurface(const Mesh& mesh, unsigned threads = 0);
    ~ReferenceSurface();
    ReferenceSurface(ReferenceSurface&&) noexcept;
    ReferenceSurface& operator=(ReferenceSurface&&) noexcept;

    /// As surface_error() of the mesh and `other`.
    [[nodiscard]] SurfaceError error_of(const Mesh& other, const SurfaceErrorOptions& options = {}) const;
    /// As SurfaceIndex::closest().
    [[nodiscard]] SurfacePoint closest(const Vec3& p, std::uint32_t near_face = kNone) const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Both meshes must be measurable() (assert). Deterministic for given samples, whatever the thread count. Distances
/// below 1e-14 of the diagonal, which is all that rounding leaves of equal surfaces, count as zero.
SurfaceError surface_error(const Mesh& reference, const Mesh& other, const SurfaceErrorOptions& options = {});

/// Distance of each vertex of `mesh` from the surface `reference`, as a fraction of the diagonal of the reference's
/// box: what error pictures are coloured by. reference must be measurable() (assert).
std::vector<double> vertex_errors(const Mesh& reference, std::span<const Vec3> positions, unsigned threads = 0);

}  // namespace mvw
