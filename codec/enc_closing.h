// Plain triangles where they serve better than wavelets: in front of them, in their place, and as a file's last part.
#pragma once
#include <optional>
#include <vector>

#include "codec/enc_input.h"
#include "codec/enc_order.h"
#include "codec/enc_part.h"

namespace mvw {

/// What a file of wavelets comes to.
struct Opening {
    const FileHeader& header;
    const std::vector<PlannedChunk>& plan;  // in file order, errors as measured (RMS) at some
    SurfaceError whole;                     // of the whole file
};

/// A file that ends with plain triangles.
struct Closing {
    FileHeader header;
    std::vector<PlannedChunk> plan;  // errors are estimates of mean squares
    std::vector<CodedPart> plain;    // the finest version, where no wavelets are left
};

struct ClosingOptions {
    bool fast = false;         // packed planes
    bool may_be_plain = true;  // wavelets may be left out
    unsigned threads = 1;
};

/// So many parts a closing adds at most.
inline constexpr std::size_t kMostStages = 2;

/// Meshes of few vertices, of sharp edges everywhere or of triangles as large as their features cost less as they are
/// than as wavelets of the same accuracy. A closing part's vertices come on a grid about as coarse as the error is by
/// then, so that the picture stays as good as it was, then in planes, tile by tile. Where a few kilobytes of plain
/// triangles are better than of wavelets, a coarse version is shown before these are (PartInfo::preview), or a
/// progressive mesh takes their place; parts without wavelets (coded by Draco alone, facets) count as such. Nothing
/// where the file would become much longer by it; surfaces that wavelets leave visibly wrong may take up to four times
/// the bytes.
std::optional<Closing> close(const EncoderInput& input, const Opening& opening, const ClosingOptions& options);

}  // namespace mvw
