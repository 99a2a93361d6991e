// Meshes that subcommands read.
#pragma once
#include <string>

#include "codec/decoder.h"
#include "codec/mesh/clean.h"

namespace mvw::cli {

/// Reads a mesh file; throws Fatal with the file's name and the reason.
Mesh load_mesh(const std::string& path);
/// The same, and what importing had to do; texture as of read_mesh().
Mesh load_mesh(const std::string& path, CleanReport& report, const std::string& texture = {});

/// The same for a .mvw file, too: as it is at `level`, or at its finest.
Mesh load_surface(const std::string& path, unsigned level = 255);
bool is_mvw(const std::string& path);

/// Says on standard error which attributes of a mesh a file of this name will not hold.
void warn_of_attributes(const std::string& path, const Mesh& mesh);

/// Says on standard error where a .mvw file of so many bytes is cut, damaged, or has bytes behind its end.
void warn_of_file(const std::string& path, const Decoder& decoder, std::uint64_t bytes);

}  // namespace mvw::cli
