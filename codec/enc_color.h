// The colours of a part as wavelet coefficients, in blocks and planes like its geometry's.
#pragma once
#include "codec/enc_part.h"

namespace mvw {

/// Appends the Color blocks of part.mesh.colors, if it has any, and sets what the base says about them. Alpha is coded
/// where one is not opaque.
void code_colors(const PartPrecision& precision, unsigned threads, CodedPart& part);

}  // namespace mvw
