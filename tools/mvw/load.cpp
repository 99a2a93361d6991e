#include "tools/mvw/load.h"

#include "codec/decoder.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tools/mvw/commands.h"

namespace mvw::cli {

Mesh load_mesh(const std::string& path) {
    CleanReport report;
    return load_mesh(path, report);
}

Mesh load_mesh(const std::string& path, CleanReport& report) {
    auto mesh = read_mesh(path, report);
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
    auto mesh = decode(*file, level);
    if (!mesh.ok()) throw Fatal{kFailure, path + ": " + mesh.error().message};
    return std::move(mesh).value();
}

}  // namespace mvw::cli
