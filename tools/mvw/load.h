// Meshes that subcommands read.
#pragma once
#include <string>

#include "codec/mesh/clean.h"

namespace mvw::cli {

/// Reads a mesh file; throws Fatal with the file's name and the reason.
Mesh load_mesh(const std::string& path);
/// The same, and what importing had to do.
Mesh load_mesh(const std::string& path, CleanReport& report);

}  // namespace mvw::cli
