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

Bytes write_ply(const Mesh& mesh);
Bytes write_obj(const Mesh& mesh);
Bytes write_stl(const Mesh& mesh);
Bytes write_off(const Mesh& mesh);

}  // namespace mvw
