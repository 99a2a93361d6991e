// What the remesher makes of every mesh of a folder, before anything is coded: figures after each of its two steps, and
// pictures.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "codec/result.h"
#include "codec/transform/transform.h"
#include "tools/bench/table.h"

namespace mvw::bench {

struct RemeshBenchOptions {
    std::string folder;             // as list_models() reads it (model_files.h)
    std::string out;                // gets remesh.csv, remesh.md, and NAME.png of each model
    std::vector<std::string> only;  // names without folder and ending; empty: all
    unsigned base_faces = 0;        // 0: chosen from the model, as by `mvw encode` before it tries other bases
    int levels = -1;                // -1: chosen from the model
    TransformKind transform = TransformOptions{}.kind;  // whose details sliding makes normal
    bool pictures = true;  // the input, the remesh with its base's edges, and coloured by error
    std::function<void(const std::string& line)> say;
};

/// Two rows a model: after remeshing, and after its vertices have slid to where details are normal (enc_adapt.h); times
/// run on from one to the other, those by phase are of the remesher alone.
/// Errors are of the finest level against the cleaned input, both ways, in dB and as a part of the diagonal; folds as
/// in folds.h. tangential: share of the energy of each level's details from level 2 up, under `seeded-lazy`, and their
/// median; `median normal`: under `seeded-normal-lazy`, which sliding for the default transform serves. Io where the
/// folder cannot be read or the output not written; a model that fails has its reason in the last column.
Result<Table> run_remesh(const RemeshBenchOptions& options);

}  // namespace mvw::bench
