// Plain triangles as a stage of a file: all of the model in one part of level 0.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "codec/enc_input.h"
#include "codec/enc_order.h"
#include "codec/enc_part.h"

namespace mvw {

/// The input, or a coarser version of it, in coded units.
struct Lod {
    SemiRegularMesh mesh;  // of level 0
    double error = 0;      // RMS, of its vertices as they are
};

/// The input itself; nothing where it is no sound base.
std::optional<Lod> own_version(const EncoderInput& input);

/// How far a version may be from the input.
struct VersionLimit {
    double rms = 0, max = 0;
};

/// Of a mesh whose positions are in coded units; nothing where it cannot be measured.
std::optional<SurfaceError> error_of(const EncoderInput& input, const std::vector<Face>& faces,
                                     std::span<const Vec3> positions, const SurfaceErrorOptions& sampling);

/// For each of the limits, which rise: the coarsest version that stays within, `own` where none does. Versions come
/// from one run of edge collapses (remesh/simplify.h).
std::vector<Lod> versions_of(const EncoderInput& input, Lod own, const std::vector<VersionLimit>& limits,
                             unsigned threads);

/// RMS error of a version with its vertices on a grid of 2^-bits.
double error_on_grid(const EncoderInput& input, const Lod& lod, unsigned bits, unsigned threads);

/// How a version is to be coded.
struct StageOptions {
    unsigned bits = 9;  // of the grid that its base comes on
    double error = 0;   // RMS, of the rounding that its planes leave; 0: no planes
    bool fast = false;  // packed planes
    unsigned threads = 1;
};

/// A version on its way into a file.
struct Stage {
    PartInfo info;
    CodedPart part;
    std::vector<PlannedChunk> chunks;  // of part 0: for the caller to number; errors are RMS, estimated but the first
    unsigned layers = 1;
};

/// Base, then planes, tile by tile: closing (PartInfo::supersedes) where there are any.
Stage code_stage(const EncoderInput& input, const Lod& lod, const StageOptions& options);

/// Likewise where a decoder has the version on a lattice already, in this order; the first chunk is of no use.
Stage code_planes_of(const EncoderInput& input, const Lod& lod, const Rounded& rounded, const StageOptions& options);

}  // namespace mvw
