// Small encoded files for tests.
#pragma once
#include <memory>

#include "codec/container/toc.h"
#include "codec/enc_remeshed.h"

namespace mvw {

/// Codes a part as the encoder does behind the remesher, against its own finest level.
Encoded encode_parts(std::vector<SemiRegularMesh> parts, EncodeOptions options = {});

/// Header and index of a whole file.
Toc toc_of(const Bytes& file);

/// A payload of the file.
ByteSpan payload_of(const Bytes& file, const ChunkEntry& chunk);

/// A bumpy ball of three levels in a few kilobytes; made once.
const Encoded& small_file();
/// The same of two levels more, coded so finely that some blocks have several chunks.
const Encoded& fine_file();

}  // namespace mvw
