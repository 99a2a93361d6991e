#include "tools/mvw/load.h"

#include <fmt/core.h>

#include <cstdio>

#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tools/mvw/commands.h"

namespace mvw::cli {

Mesh load_mesh(const std::string& path) {
    CleanReport report;
    return load_mesh(path, report);
}

Mesh load_mesh(const std::string& path, CleanReport& report, const std::string& texture) {
    auto mesh = read_mesh(path, report, texture);
    if (!mesh.ok()) throw Fatal{kFailure, mesh.error().message};
    return std::move(mesh).value();
}

bool is_mvw(const std::string& path) {
    return path.ends_with(".mvw");
}

Mesh load_surface(const std::string& path, unsigned level) {
    if (!is_mvw(path)) return load_mesh(path);
    const auto file = read_file(path);
    if (!file.ok()) throw Fatal{kFailure, file.error().message};
    const Result<FileHeader> header = read_header(*file);
    if (!header.ok()) throw Fatal{kFailure, path + ": " + header.error().message};
    Decoder decoder;
    if (!decoder.feed_file(*file)) {
        (void)decoder.feed(*file).ok();
        decoder.finish();
    }
    auto mesh = decoder.mesh(level);
    if (!mesh.ok()) throw Fatal{kFailure, path + ": " + mesh.error().message};
    warn_of_file(path, decoder, file->size());
    return std::move(mesh).value();
}

void warn_of_attributes(const std::string& path, const Mesh& mesh) {
    const auto format = mesh_format_of(path);
    if (!format) return;
    for (const std::string& name : left_out_by(*format, mesh))
        fmt::print(stderr, "mvw: {}: the format cannot hold attribute {}: left out\n", path, name);
}

void warn_of_file(const std::string& path, const Decoder& decoder, std::uint64_t bytes) {
    const std::uint64_t whole = decoder.header()->file_bytes();
    if (bytes < whole)
        fmt::print(stderr, "mvw: {}: cut at byte {} of {}: this is the best mesh that they hold\n", path, bytes, whole);
    if (bytes > whole) fmt::print(stderr, "mvw: {}: {} bytes behind its end were left out\n", path, bytes - whole);
    if (const auto damaged = decoder.state().damaged; damaged > 0)
        fmt::print(stderr, "mvw: {}: {} damaged chunks were left out (mvw verify names them)\n", path, damaged);
}

}  // namespace mvw::cli
