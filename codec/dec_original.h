// The input mesh as a file may carry it in its last chunk, for people who need their measured vertices.
#pragma once
#include "codec/container/toc.h"
#include "codec/mesh/mesh.h"

namespace mvw {

/// Reads an Original payload (FORMAT.md 4.6): positions on a grid, in model units. Counts are held against the bytes
/// present and the limits before Draco allocates.
Result<Mesh> read_original(ByteSpan payload, const FileHeader& header, const Limits& limits = {});

/// Finds it in a whole file, and checks its checksum. NeedMoreData where the file is cut, InvalidArgument where it has
/// none.
Result<Mesh> decode_original(ByteSpan file, const Limits& limits = {});

}  // namespace mvw
