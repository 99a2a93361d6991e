// The triangle mesh that enters and leaves the codec: indexed triangles with optional attributes.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "codec/vec.h"

namespace mvw {

/// Three vertex indices, counter-clockwise seen from outside.
using Face = std::array<std::uint32_t, 3>;

/// 8-bit sRGB colour with straight alpha.
struct Rgba8 {
    std::uint8_t r = 255, g = 255, b = 255, a = 255;
    friend constexpr bool operator==(const Rgba8&, const Rgba8&) = default;
};

/// What a field says of a vertex.
enum class FieldKind : std::uint8_t { Scalar, Normals };

/// Numbers at vertices, vertex by vertex: a measured quantity (one number each, finite, known by its name), or normals
/// (three each, of unit length or zero where a vertex has none, no name).
struct VertexField {
    FieldKind kind = FieldKind::Scalar;
    std::string name;            // of a scalar: 1 to kMaxFieldName characters from '!' to '~'
    std::vector<double> values;  // V times components()

    [[nodiscard]] std::size_t components() const { return kind == FieldKind::Normals ? 3 : 1; }
};
inline constexpr std::size_t kMaxFieldName = 63;

/// The colour of a material, by its label.
struct MaterialColor {
    std::uint32_t label = 0;
    Rgba8 color;
    friend constexpr bool operator==(const MaterialColor&, const MaterialColor&) = default;
};

class Paintwork;

/// Indexed triangle mesh.
///
/// positions  V points, model units, finite
/// faces      F triangles, indices below V
/// colors     empty, or V per-vertex colours
/// materials  empty, or F labels; faces of one material have one label
/// fields     any number of scalars of different names, and normals at most once
/// material_colors  colours of faces by label, 0 where `materials` is empty; labels rising. Faces of other labels have
///            the colours of their vertices (material_colors.h)
/// paintwork  null, or what a file's materials and images say of the surface between its vertices (paintwork.h)
struct Mesh {
    std::vector<Vec3> positions;
    std::vector<Face> faces;
    std::vector<Rgba8> colors;
    std::vector<std::uint32_t> materials;
    std::vector<VertexField> fields{};
    std::vector<MaterialColor> material_colors{};
    std::shared_ptr<const Paintwork> paintwork{};
};

/// Axis-aligned box; empty (min > max) until a point is added.
struct Box {
    Vec3 min{1e300, 1e300, 1e300}, max{-1e300, -1e300, -1e300};

    void add(const Vec3& p) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (p[k] < min[k]) min[k] = p[k];
            if (p[k] > max[k]) max[k] = p[k];
        }
    }
    [[nodiscard]] bool empty() const { return min.x > max.x; }
    [[nodiscard]] Vec3 center() const { return (min + max) * 0.5; }
    [[nodiscard]] double diagonal() const { return empty() ? 0.0 : length(max - min); }
};

/// Box around the vertices that faces use: the yardstick of every error in this project.
inline Box bounding_box(const Mesh& mesh) {
    Box box;
    for (const Face& f : mesh.faces)
        for (const std::uint32_t v : f) box.add(mesh.positions[v]);
    return box;
}

}  // namespace mvw
