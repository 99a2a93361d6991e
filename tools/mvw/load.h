// Meshes that subcommands read.
#pragma once
#include <string>

#include "codec/mesh/mesh.h"

namespace mvw::cli {

/// Reads a mesh file; throws Fatal with the file's name and the reason.
Mesh load_mesh(const std::string& path);

}  // namespace mvw::cli
