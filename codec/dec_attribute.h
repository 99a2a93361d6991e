// What a part's attributes are, and one attribute of a part's vertices: coefficients as far as its blocks have come,
// and the values that they give.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "codec/container/toc.h"
#include "codec/mesh/semi_regular.h"
#include "codec/part_params.h"

namespace mvw {

/// An Attributes chunk (FORMAT.md 4.8): Malformed, Unsupported as it says. No channel comes twice.
Result<std::vector<AttributeParams>> read_attributes(ByteSpan payload, const PartInfo& info);

/// Flags of the base edges across which attributes may jump: between two materials. Empty where there is one material.
std::vector<std::uint8_t> attribute_creases(const BaseMesh& base, std::span<const std::uint32_t> materials);

class AttributeDecoder {
 public:
    explicit AttributeDecoder(AttributeParams params) : params_(std::move(params)) {}

    [[nodiscard]] const AttributeParams& params() const { return params_; }
    /// Makes room for coefficients of vertices below `vertices`, those of `base_vertices` at their origin.
    void ensure(std::size_t vertices, std::size_t base_vertices);
    /// Of one block: blocks of other vertices may come in beside. values: coefficient-major, in units of steps.
    void store(std::span<const std::uint32_t> indices, unsigned level, std::span<const float> values);
    /// In hierarchical order: the first three components, and the fourth in x; one may be empty.
    [[nodiscard]] const std::array<std::vector<Vec3f>, 2>& coefficients() const { return coefficients_; }
    /// Appends V(level) values to the mesh, which has the vertices and faces already, those of this part from
    /// `first_vertex` and `first_face`; vertices before without the attribute get white, or zeros.
    void append(PatchTransform& transform, unsigned level, std::size_t first_vertex, std::size_t first_face,
                Mesh& out) const;

 private:
    void append_colors(std::span<const Vec3f> values, std::span<const Vec3f> alphas, Mesh& out) const;
    void append_scalars(std::span<const Vec3f> values, std::vector<double>& out) const;

    AttributeParams params_;
    std::array<std::vector<Vec3f>, 2> coefficients_;  // grow with the levels in use
};

/// Gives attributes that end before the last vertex white, or zeros, for the rest.
void pad_vertex_data(Mesh& mesh);

}  // namespace mvw
