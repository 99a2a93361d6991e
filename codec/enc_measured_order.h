// Orders a file's chunks by what they are measured to gain where they lie: estimates of one plane at a time do not see
// that coarse levels left rough spoil what finer ones add.
#pragma once
#include <vector>

#include "codec/enc_input.h"
#include "codec/enc_order.h"
#include "codec/encoder.h"

namespace mvw {

/// file: of the plan, for its header. Decodes the chunks one after the other, replaces their gains by measured ones
/// and sorts them anew where beginnings of the file get better by it; again where they got much better. Joins chunks
/// that make the surface worse with the next ones of their blocks, where beginnings lose next to nothing by it; not
/// packed planes. Leaves plans of many chunks of many vertices as they are: that would take long.
void order_by_measure(const EncoderInput& input, ByteSpan file, std::vector<PlannedChunk>& plan,
                      const EncodeOptions& options);

}  // namespace mvw
