#include "tools/mvw/load.h"

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

}  // namespace mvw::cli
