// Whole files to and from memory.
#pragma once
#include <string>

#include "codec/bytes.h"
#include "codec/result.h"

namespace mvw {

/// All bytes of a regular file. The error names the path and the system's reason.
Result<Bytes> read_file(const std::string& path);

/// The same of a file in `folder` (which ends in a slash) or below. InvalidArgument where `name` leads out of it, or
/// the folder is null.
Result<Bytes> read_file_below(const std::string* folder, std::string name);

/// Writes beside the final name, then renames: a reader sees the old file or the whole new one. What was written is
/// removed where anything fails; the error names the path and the system's reason.
Result<void> write_file(const std::string& path, ByteSpan bytes);

}  // namespace mvw
