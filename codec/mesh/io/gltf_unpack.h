// Makes compressed and sparse data of a glTF model plain, so that its other readers need not know of them: views of
// EXT_meshopt_compression, primitives of KHR_draco_mesh_compression, sparse accessors.
#pragma once
#include <tiny_gltf.h>

#include <nlohmann/json.hpp>

#include "codec/result.h"

namespace mvw {

/// Gives what tinygltf asks for and these extensions leave out: data of buffers that are to be filled by unpacking, and
/// views of Draco's indices. True where it changed anything.
bool complete_for_tinygltf(nlohmann::json& gltf);

/// Unpacks what the model's triangles and instances use: their accessors then read as if never packed. Malformed where
/// the bytes contradict their extension, LimitExceeded where they would unpack to more than they can hold.
Result<void> unpack(tinygltf::Model& model);

}  // namespace mvw
