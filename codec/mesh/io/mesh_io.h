// Reads and writes triangle meshes by file ending: .ply .obj .stl .off .gltf .glb. The formats themselves are left to
// libraries; what they return is checked here.
#pragma once
#include <string>

#include "codec/mesh/clean.h"
#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

/// Reads a mesh: polygons triangulated (counted in the report), not cleaned otherwise. Errors name the file and the
/// reason: missing, unreadable, truncated, no faces, an index out of range, a coordinate that is not finite.
Result<Mesh> read_mesh(const std::string& path, CleanReport& report);

/// Writes beside the final name, then renames. Colours are kept where the format has them (not STL, OFF as COFF).
Result<void> write_mesh(const std::string& path, const Mesh& mesh);

}  // namespace mvw
