// Where a glTF node puts its mesh: its transform, and its instances.
#pragma once
#include <tiny_gltf.h>

#include <vector>

#include "codec/mesh/io/affine.h"
#include "codec/result.h"

namespace mvw {

/// From the node's space to its parent's.
Affine transform_of(const tinygltf::Node& node);

/// Its extension of instances.
inline constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
/// From its mesh's space to the node's, for each instance (EXT_mesh_gpu_instancing); one without that extension.
/// Malformed where there are no such accessors or they do not fit each other.
Result<std::vector<Affine>> instances_of(const tinygltf::Model& model, const tinygltf::Node& node);

}  // namespace mvw
