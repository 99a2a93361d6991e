// ZIP archives for tests.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "codec/bytes.h"

namespace mvw {

/// Of files by name, each deflated.
Bytes zip_of(const std::vector<std::pair<std::string, std::string>>& files);

/// A 3MF package whose relationships say that `model` is its model.
Bytes threemf_of(const std::string& model);

}  // namespace mvw
