// One reader and one writer for each file format; mesh_io.h chooses among them.
#pragma once
#include <string>

#include "codec/bytes.h"
#include "codec/mesh/io/polygons.h"
#include "codec/result.h"

namespace mvw {

// Errors give the reason only; mesh_io.cpp puts the file's name before it.
Result<Polygons> read_ply(ByteSpan bytes);
Result<Polygons> read_obj(ByteSpan bytes);
Result<Polygons> read_stl(ByteSpan bytes);
Result<Polygons> read_off(ByteSpan bytes);
/// binary: .glb. Outer buffers are read from below `folder` (ending in a slash), refused where it is null.
Result<Polygons> read_gltf(ByteSpan bytes, bool binary, const std::string* folder);

Bytes write_ply(const Mesh& mesh);
Bytes write_obj(const Mesh& mesh);
Bytes write_stl(const Mesh& mesh);
Bytes write_off(const Mesh& mesh);
Result<Bytes> write_glb(const Mesh& mesh);

/// True where float32 would move a vertex by over 1e-6 of the diagonal.
bool needs_double(const Mesh& mesh);

}  // namespace mvw
