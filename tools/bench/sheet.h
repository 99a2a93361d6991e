// What a model looks like at each level, as figures and as one picture.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "codec/result.h"
#include "tools/bench/backs.h"
#include "tools/bench/folds.h"

namespace mvw::bench {

struct Inspection {
    std::uint64_t folds = 0, input_folds = 0;  // of the finest level, of the cleaned input (folds.h)
    std::vector<BackPixels> backs;             // of each level; empty without a picture
    BackPixels input_backs;                    // of the cleaned input
    Topology topology;                         // of the cleaned input
    bool topology_kept = true;                 // by every level
    std::string topology_trouble;              // which level has what instead
};

/// Decodes every level of `mvw_file` and holds it against `input_file`. Draws the input and each level, plain as it is
/// seen and with triangles and backs in place, and the finest level coloured by error, into the PNG `sheet` ("": no
/// picture, nor backs).
Result<Inspection> inspect(const std::string& input_file, const std::string& mvw_file, const std::string& sheet);

}  // namespace mvw::bench
