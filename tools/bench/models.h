// The table of models: every mesh of a folder encoded, decoded and compared by the program itself, as a user would.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "codec/result.h"
#include "tools/bench/table.h"

namespace mvw::bench {

struct ModelsOptions {
    std::string folder;             // its meshes (also .zst-packed ones), and those of its subfolders but `tiny`
    std::string out;                // gets models.csv, models.md, and per model NAME.mvw and NAME.png
    std::vector<std::string> only;  // names without folder and ending; empty: all
    std::vector<std::string> encode_extra;             // further arguments for `mvw encode`
    bool pictures = true;                              // without them backs are not counted either (backs.h)
    std::function<void(const std::string& line)> say;  // one line per model as it is done
};

/// Runs all models, smallest file first. A model that fails has its reason in the last column and does not stop the
/// rest. Io where the folder cannot be read or the output not written.
Result<Table> run_models(const ModelsOptions& options);

}  // namespace mvw::bench
