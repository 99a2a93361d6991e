// Whether what the server sends is what the encoder wrote.
#pragma once
#include <string>
#include <vector>

#include "codec/result.h"

namespace mvw::bench {

/// Serves `folder` by `mvw serve` on a loopback port of its own and fetches each model (name without .mvw) by
/// `mvw fetch`. One answer per model: "yes" where the file that came is, byte for byte, the one that is served; else
/// what went wrong. Io where the server does not start.
Result<std::vector<std::string>> stream_models(const std::string& folder, const std::vector<std::string>& models);

}  // namespace mvw::bench
