// From semi-regular parts to a file: the encoder behind the remesher.
#pragma once
#include "codec/encoder.h"

namespace mvw {

/// Codes `remeshed` (of `input`, against which every error is measured) into a file. `out` comes with what is known of
/// the input and gets the rest. Errors as encode()'s.
Result<void> encode_remeshed(const Mesh& input, RemeshResult remeshed, const EncodeOptions& options, Encoded& out);

}  // namespace mvw
