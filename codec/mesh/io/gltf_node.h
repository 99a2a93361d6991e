// Where a glTF node puts its mesh: its transform, and its instances.
#pragma once
#include <tiny_gltf.h>

#include <array>
#include <vector>

#include "codec/result.h"
#include "codec/vec.h"

namespace mvw {

/// Rows of an affine map: linear part and translation.
struct Affine {
    std::array<Vec3, 3> row{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    Vec3 shift;

    [[nodiscard]] Vec3 linear(const Vec3& p) const { return {dot(row[0], p), dot(row[1], p), dot(row[2], p)}; }
    [[nodiscard]] Vec3 operator()(const Vec3& p) const { return linear(p) + shift; }
    [[nodiscard]] double determinant() const { return dot(row[0], cross(row[1], row[2])); }
    /// Along the normal of a surface that is mapped, where `n` is along it before.
    [[nodiscard]] Vec3 normal(const Vec3& n) const;
    /// First `inner`, then this.
    [[nodiscard]] Affine after(const Affine& inner) const;
};

/// From the node's space to its parent's.
Affine transform_of(const tinygltf::Node& node);

/// Its extension of instances.
inline constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
/// From its mesh's space to the node's, for each instance (EXT_mesh_gpu_instancing); one without that extension.
/// Malformed where there are no such accessors or they do not fit each other.
Result<std::vector<Affine>> instances_of(const tinygltf::Model& model, const tinygltf::Node& node);

}  // namespace mvw
