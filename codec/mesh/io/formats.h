// One reader and one writer for each file format; mesh_io.h chooses among them.
#pragma once
#include <string>

#include "codec/bytes.h"
#include "codec/mesh/io/polygons.h"
#include "codec/result.h"

namespace mvw {

/// What a mesh file may look at beside itself.
struct Surroundings {
    const std::string* folder = nullptr;  // ends in a slash: outer files are read from it and from below; none if null
    ByteSpan texture{};                   // for surfaces with texture coordinates whose file names no image
};

// Errors give the reason only; mesh_io.cpp puts the file's name before it.
Result<Polygons> read_ply(ByteSpan bytes);
Result<Polygons> read_obj(ByteSpan bytes, const Surroundings& around);
Result<Polygons> read_stl(ByteSpan bytes);
Result<Polygons> read_off(ByteSpan bytes);
Result<Polygons> read_3mf(ByteSpan bytes);
/// binary: .glb.
Result<Polygons> read_gltf(ByteSpan bytes, bool binary, const Surroundings& around);

Bytes write_ply(const Mesh& mesh);
Bytes write_obj(const Mesh& mesh);
Bytes write_stl(const Mesh& mesh);
Bytes write_off(const Mesh& mesh);
Result<Bytes> write_glb(const Mesh& mesh);

/// The mesh's normals, null where it has none.
const VertexField* normals_of(const Mesh& mesh);
/// True where float32 would move a vertex by over 1e-6 of the diagonal.
bool needs_double(const Mesh& mesh);
/// True where float32 would change a scalar by over 1e-6 of its range.
bool needs_double(const VertexField& field);

}  // namespace mvw
