// Reads and writes triangle meshes by file ending: .ply .obj .stl .off .gltf .glb, and reads .3mf.
// OBJ and glTF are left to libraries (tinyobjloader, tinygltf) whose answers are checked here. PLY, OFF, STL and 3MF
// have readers of their own: see ply.cpp, off.cpp, stl.cpp and threemf.cpp for what the libraries at hand lost.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

enum class MeshFormat : std::uint8_t { Ply, Obj, Stl, Off, Gltf, Glb, ThreeMf };

/// The format that a path's ending names, in capitals or not.
std::optional<MeshFormat> mesh_format_of(const std::string& path);
/// Whether write_mesh() writes files of this name: not .gltf, .3mf and unknown ones.
bool can_write_mesh(const std::string& path);

/// Reads a mesh: polygons triangulated (counted in the report), not cleaned otherwise. Colours are those of vertices;
/// materials are labels, present where a file uses more than one. Errors name the file and the reason: missing,
/// unreadable, truncated, no faces, an index out of range, a coordinate that is not finite.
///
/// Fields are the scalar properties of PLY vertices, glTF's _NAME attributes of one number, and normals; OBJ's corners
/// give their vertex the mean of their normals. Colours of materials (OBJ's Kd, glTF's baseColorFactor, 3MF's
/// base materials and groups of colours, but none of its images) are those of the mesh's materials, unless all are one
/// grey; where some have images (OBJ's map_Kd, glTF's baseColorTexture; PNG, JPEG or WebP), the mesh has a paintwork,
/// and its vertices that paintwork's colours, the mean of their corners' where seams give them several. texture: an
/// image for OBJ files with texture coordinates that name none.
Result<Mesh> read_mesh(const std::string& path, CleanReport& report, const std::string& texture = {});

/// The same of bytes in memory, for files that never were one. A .gltf may name no outer buffers then. Any bytes give
/// a mesh or an error; memory stays in proportion to their number.
Result<Mesh> read_mesh_from_memory(ByteSpan bytes, MeshFormat format, CleanReport& report);

/// Writes beside the final name, then renames. Positions are
/// float32 in STL. So in PLY and GLB, unless that moves a vertex by over 1e-6 of the diagonal: then PLY has doubles and
/// GLB counts from the box's centre. OBJ and OFF hold decimals that read back as the same doubles. Colours are kept but
/// in STL (in OBJ without alpha), those of materials as such in GLB and at vertices elsewhere, which are there once for
/// each of several colours; materials in OBJ and GLB, normals in PLY, OBJ and GLB, scalars in PLY (doubles where
/// float32 would change one by over 1e-6 of its range) and GLB (float32, as _NAME). Neither .gltf nor .3mf is
/// written: ask for .glb.
Result<void> write_mesh(const std::string& path, const Mesh& mesh);

/// Names of attributes of the mesh that files of the format do not hold.
std::vector<std::string> left_out_by(MeshFormat format, const Mesh& mesh);

/// The bytes that write_mesh() puts into a file of that format.
Result<Bytes> write_mesh_to_memory(const Mesh& mesh, MeshFormat format);

}  // namespace mvw
