// A progressive mesh as a stage of a file: a coarse version of the input, vertex splits that lead to a fine one,
// planes.
#pragma once
#include <optional>

#include "codec/enc_stage.h"

namespace mvw {

struct ProgressiveOptions {
    double base_bytes = 900;  // that the coarse version may take, if one can be so coarse
    double error = 0;         // RMS, of the rounding that planes leave
    bool fast = false;        // packed planes
    unsigned threads = 1;
};

struct Progressive {
    Stage whole;                  // errors of the base and of splits are measured, those of planes are estimates
    std::vector<PartInfo> grown;  // with no chunk of splits, one, ...

    /// The first so many chunks of splits, below grown.size(), and no planes.
    [[nodiscard]] Stage beginning(std::size_t splits) const;
};

/// version: the fine one. Nothing where no coarser one can be told from it by splits.
std::optional<Progressive> code_progressive(const EncoderInput& input, const Lod& version,
                                            const ProgressiveOptions& options);

}  // namespace mvw
