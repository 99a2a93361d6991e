// Colours of materials, and how those who know colours of vertices alone get them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "codec/mesh/mesh.h"

namespace mvw {

/// The colour of a label; null where it has none.
const Rgba8* color_of(std::span<const MaterialColor> colors, std::uint32_t label);

/// Whether all faces with these labels (one label 0 where there are none) have a colour.
bool all_have_colors(std::span<const MaterialColor> colors, std::span<const std::uint32_t> labels);

/// An opaque colour that all vertices have, as many tools write it, becomes that of all faces, as the label 0's. Nothing
/// where colours differ, or where there are materials.
void single_color_to_material(Mesh& mesh);

/// Moves the colours of materials to vertices, those between two colours being there once for each: copies come last.
/// There are at most as many copies as vertices were; beyond, vertices keep their first colour. Returns what each copy
/// is one of. Nothing where materials have no colours. O(V + F), and a search for each corner between two colours.
std::vector<std::uint32_t> colors_to_vertices(Mesh& mesh);

}  // namespace mvw
