#include "tests/support/models.h"

#include <zstd.h>

#include <cstdlib>
#include <filesystem>

#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"

namespace mvw {
namespace {

Result<Bytes> unpack(ByteSpan packed) {
    const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (size >= (1ull << 32)) return Error{Errc::Malformed, 0, "states no sensible unpacked size"};
    Bytes bytes(size);
    const std::size_t got = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
    if (got != size) return Error{Errc::Malformed, 0, "cannot be unpacked"};
    return bytes;
}

std::string without_packing(const std::string& name) {
    return name.size() > 4 && name.substr(name.size() - 4) == ".zst" ? name.substr(0, name.size() - 4) : name;
}

}  // namespace

std::string models_folder() {
    const char* set = std::getenv("MVW_MODELS");
    std::string folder = set == nullptr ? "" : set;
    while (!folder.empty() && folder.back() == '/') folder.pop_back();
    return folder;
}

Result<Bytes> model_bytes(const std::string& name) {
    const std::string path = models_folder() + "/" + without_packing(name);
    if (std::filesystem::exists(path)) return read_file(path);
    const Result<Bytes> packed = read_file(path + ".zst");
    return packed ? unpack(*packed) : packed;
}

Result<Mesh> read_model(const std::string& name, CleanReport& report) {
    const std::string path = models_folder() + "/" + without_packing(name);
    if (std::filesystem::exists(path)) return read_mesh(path, report);
    const Result<Bytes> bytes = model_bytes(name);
    if (!bytes) return bytes.error();
    const auto format = mesh_format_of(path);
    if (!format) return Error{Errc::InvalidArgument, 0, path + ": has no known ending"};
    return read_mesh_from_memory(*bytes, *format, report);
}

Mesh clean_model(const std::string& name) {
    CleanReport report;
    Result<Mesh> mesh = read_model(name, report);
    if (!mesh) {
        ADD_FAILURE() << name << ": " << mesh.error().message;
        return {};
    }
    return clean(std::move(mesh).value(), report);
}

}  // namespace mvw
