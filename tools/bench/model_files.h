// The mesh files of a folder, for benchmarks that run over one.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "codec/result.h"

namespace mvw::bench {

struct ModelFile {
    std::filesystem::path file;
    std::string name;  // without folder and ending
};

/// The meshes of a folder (also .zst-packed ones) and of its subfolders but `tiny`, smallest file first. only: names;
/// empty: all. Io where the folder cannot be read.
Result<std::vector<ModelFile>> list_models(const std::string& folder, const std::vector<std::string>& only);

/// The model as a file that mvw reads: itself, or unpacked into the folder `out`.
Result<std::string> unpacked(const ModelFile& model, const std::string& out);

}  // namespace mvw::bench
