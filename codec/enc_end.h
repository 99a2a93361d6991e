// Where a file ends: its last planes may bring the surface no nearer to the input, but to what remeshing made of it.
#pragma once
#include <vector>

#include "codec/enc_input.h"
#include "codec/enc_order.h"

namespace mvw {

/// file: of the plan, for its header. Takes the last geometry away from a plan while what is left is measured to be as
/// near to the input: slices of chunks, of which the last becomes the beginning of one (FORMAT.md 4.5), or, as cut
/// packed planes show nothing, `whole_chunks` alone.
void cut_end(const EncoderInput& input, ByteSpan file, std::vector<PlannedChunk>& plan, bool whole_chunks,
             unsigned threads);

}  // namespace mvw
