#include "tools/bench/model_files.h"

#include <zstd.h>

#include <algorithm>
#include <array>

#include "codec/bytes.h"
#include "codec/mesh/io/files.h"

namespace mvw::bench {
namespace {

namespace fs = std::filesystem;

std::string ending(const fs::path& file) {
    return file.extension() == ".zst" ? file.stem().extension().string() : file.extension().string();
}

std::string stem(const fs::path& file) {
    return file.extension() == ".zst" ? file.stem().stem().string() : file.stem().string();
}

}  // namespace

Result<std::vector<ModelFile>> list_models(const std::string& folder, const std::vector<std::string>& only) {
    constexpr std::array<const char*, 7> kEndings{".ply", ".obj", ".stl", ".off", ".gltf", ".glb", ".3mf"};
    std::error_code error;
    std::vector<ModelFile> models;
    fs::recursive_directory_iterator walk(folder, error), end;
    for (; !error && walk != end; walk.increment(error)) {
        if (walk->path().filename() == "tiny") walk.disable_recursion_pending();
        if (!walk->is_regular_file() ||
            std::find(kEndings.begin(), kEndings.end(), ending(walk->path())) == kEndings.end())
            continue;
        const ModelFile model{walk->path(), stem(walk->path())};
        if (only.empty() || std::count(only.begin(), only.end(), model.name) > 0) models.push_back(model);
    }
    if (error) return Error{Errc::Io, 0, folder + ": " + error.message()};
    std::sort(models.begin(), models.end(), [](const ModelFile& a, const ModelFile& b) {
        return std::pair(fs::file_size(a.file), a.name) < std::pair(fs::file_size(b.file), b.name);
    });
    return models;
}

Result<std::string> unpacked(const ModelFile& model, const std::string& out) {
    if (model.file.extension() != ".zst") return model.file.string();
    const auto packed = read_file(model.file.string());
    if (!packed) return packed.error();
    const unsigned long long size = ZSTD_getFrameContentSize(packed->data(), packed->size());
    if (size >= (1ull << 32)) return Error{Errc::Malformed, 0, model.file.string() + ": states no sensible size"};
    Bytes bytes(size);
    if (ZSTD_decompress(bytes.data(), bytes.size(), packed->data(), packed->size()) != size)
        return Error{Errc::Malformed, 0, model.file.string() + ": cannot be unpacked"};
    const std::string path = out + "/" + model.name + ending(model.file);
    if (auto written = write_file(path, bytes); !written) return written.error();
    return path;
}

}  // namespace mvw::bench
