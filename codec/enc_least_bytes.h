// From how many bytes on a cut chunk is shown. A plane's first symbols may move single vertices far along the surface,
// at a sharp edge say, before their neighbours follow.
#pragma once
#include <vector>

#include "codec/enc_input.h"
#include "codec/enc_order.h"

namespace mvw {

/// file: of the plan, its chunks in the same order. Decodes beginnings that end within the first chunk of a block of
/// level 1 or higher. Where some are farther from the input than the file without any of the chunk, the plan's chunk
/// says how many bytes it takes until they are not (FORMAT.md 4.5). Leaves plans of many such chunks of many vertices
/// as they are: that would take long.
void say_least_bytes(const EncoderInput& input, ByteSpan file, std::vector<PlannedChunk>& plan, unsigned threads);

}  // namespace mvw
