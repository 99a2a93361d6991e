// The input's own triangles as a file's last part, where that closes it better than wavelets do.
#pragma once
#include <optional>
#include <vector>

#include "codec/enc_input.h"
#include "codec/enc_order.h"
#include "codec/enc_part.h"

namespace mvw {

/// What a file of wavelets comes to.
struct Opening {
    ByteSpan file;
    const std::vector<PlannedChunk>& plan;  // in file order, errors as measured (RMS) at some
    unsigned layers = 1;
    SurfaceError whole;  // of the whole file
};

/// A last part, and what of the wavelets stays before it.
struct Closing {
    PartInfo info;
    std::vector<PlannedChunk> chunks;       // of part 0: for the caller to number; errors are estimates of mean squares
    std::size_t opening_chunks = 0;         // that stay, ...
    std::optional<PlannedChunk> beginning;  // ... and of the next one so much
    double base_error = 0;                  // RMS, once the part's base is there
    unsigned layers = 1;                    // of the file
};

struct ClosingOptions {
    bool fast = false;  // packed planes
    unsigned threads = 1;
};

/// Meshes of few vertices, of sharp edges everywhere or of triangles as large as their features cost less as they are
/// than as wavelets of the same accuracy. The vertices come on a grid about as coarse as the wavelets' error is by
/// then, so that the picture stays as good as it was, then in planes, tile by tile. Nothing where the file would become
/// much longer by it; surfaces that wavelets leave visibly wrong may take up to four times the bytes.
std::optional<Closing> close(const EncoderInput& input, const Opening& opening, const ClosingOptions& options);

}  // namespace mvw
