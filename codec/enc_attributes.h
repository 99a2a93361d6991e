// The colours and fields of a part as wavelet coefficients, in blocks and planes like its geometry's.
#pragma once
#include "codec/enc_part.h"

namespace mvw {

/// The payload of an Attributes chunk.
Bytes write_attributes(const std::vector<AttributeParams>& attributes);

/// Appends the blocks of part.mesh's colours, if it has any, and of its fields, kMaxFields at most, and says what they
/// are in part.attributes. Alpha is coded where one is not opaque.
void code_attributes(const PartPrecision& precision, unsigned threads, CodedPart& part);

}  // namespace mvw
