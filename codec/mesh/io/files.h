// Whole files to and from memory.
#pragma once
#include <string>

#include "codec/bytes.h"
#include "codec/result.h"

namespace mvw {

/// All bytes of a regular file. The error names the path and the system's reason.
Result<Bytes> read_file(const std::string& path);

/// Writes beside the final name, then renames: a reader sees the old file or the whole new one. What was written is
/// removed where anything fails; the error names the path and the system's reason.
Result<void> write_file(const std::string& path, ByteSpan bytes);

}  // namespace mvw
