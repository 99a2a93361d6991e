// What the readers hand over: polygons as a file states them, still unchecked.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codec/mesh/clean.h"
#include "codec/mesh/io/paint.h"
#include "codec/mesh/mesh.h"
#include "codec/result.h"

namespace mvw {

/// Polygon p has corners [starts[p], starts[p+1]). Colours may be missing, or fewer than the positions: the rest is
/// white. Materials: none, or a label for each polygon. Fields likewise: of missing normals nothing is known, missing
/// numbers are not finite.
struct Polygons {
    std::vector<Vec3> positions;
    std::vector<Rgba8> colors;
    std::vector<std::uint32_t> corners;
    std::vector<std::uint32_t> starts{0};
    std::vector<std::uint32_t> materials;
    std::vector<VertexField> fields;
    std::vector<std::string> dropped_fields;    // names of what is not kept
    std::vector<std::string> missing_textures;  // images that could not be read, and why
    // Where materials have colours or images, and then in place of `colors`: paints, the number of each polygon's, each
    // corner's place (u, v) in the image (not finite where it has none), and nothing or what is multiplied with that at
    // each vertex.
    std::vector<Paint> paints;
    std::vector<std::uint32_t> paint_of;
    std::vector<std::array<float, 2>> coordinates;
    std::vector<std::array<float, 4>> tints;

    [[nodiscard]] std::size_t count() const { return starts.size() - 1; }
    /// Ends the polygon whose corners were pushed.
    void end_polygon() { starts.push_back(static_cast<std::uint32_t>(corners.size())); }
};

/// Index of the field of this kind and name, made where there is none yet. Characters that field names do not have
/// become '_'. None where there are kMostFields already: then the name is dropped.
std::optional<std::size_t> field_of(Polygons& polygons, FieldKind kind, std::string_view name);
inline constexpr std::size_t kMostFields = 64;
/// Sets what the field says of a vertex; vertices before of which it says nothing have numbers that are not finite.
void set_value(VertexField& field, std::size_t vertex, std::span<const double> value);
/// Takes note of a name that is not kept, once, and of kMostFields at most.
void drop_field(Polygons& polygons, std::string name);

/// Index of no vertex: what readers put for a number that is no index at all.
inline constexpr std::uint32_t kBadIndex = 0xFFFFFFFFu;

/// Checks and triangulates. Malformed where there is no face, an index is out of range or a coordinate is not finite;
/// LimitExceeded where there are more faces than half-edges can be numbered. Polygons of less than three corners are
/// dropped and counted as degenerate.
Result<Mesh> to_mesh(Polygons polygons, CleanReport& report);

/// Triangulates one polygon of n >= 3 corners into n - 2 triangles that use all of its sides, appended to `faces`:
/// ears are clipped in the plane that fits best (Newell's normal), so concave polygons come out right; a polygon that
/// crosses itself still gives n - 2 triangles. `budget` counts down the tests of a corner against an ear; with none
/// left, what remains is cut as a fan, so that work stays bounded.
void triangulate(const std::vector<Vec3>& positions, const std::uint32_t* corners, std::size_t n,
                 std::vector<Face>& faces, std::uint64_t& budget);

}  // namespace mvw
