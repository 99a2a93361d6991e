// Materials through remeshing: borders between them are curves that base edges follow, so each base face has one.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/remesh/recognize.h"

namespace mvw {

/// Sets the flags (3 * face + side) of both halves of each edge between faces of different materials. mesh: clean.
/// O(F log F).
void flag_material_borders(const Mesh& mesh, std::vector<std::uint8_t>& half_edges);

/// The material of each base face; empty where the mesh has none, nothing where a base face would have several.
/// O(F log F).
std::optional<std::vector<std::uint32_t>> materials_of(const Mesh& mesh, const Recognized& found);

}  // namespace mvw
