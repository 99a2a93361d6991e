// Base colours of glTF materials: a factor, and an image or none.
#pragma once
#include <tiny_gltf.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "codec/mesh/io/paint.h"

namespace mvw {

/// The paints of all materials that primitives use, white in front for primitives without one.
class GltfPaints {
 public:
    /// Images are decoded, those of the model's files too; the model must outlive this.
    explicit GltfPaints(const tinygltf::Model& model);

    [[nodiscard]] const std::vector<Paint>& paints() const { return paints_; }
    /// Number of a primitive's paint.
    [[nodiscard]] std::uint32_t number_of(int material) const;
    /// The attribute that says where in a paint's image a vertex lies.
    [[nodiscard]] const std::string& coordinates_of(std::uint32_t paint) const { return coordinates_[paint]; }
    /// Whether they tell anything (are_plain()).
    [[nodiscard]] bool paint() const { return paint_; }
    /// Images that could not be read, and why.
    [[nodiscard]] const std::vector<std::string>& missing() const { return missing_; }

 private:
    void add(const tinygltf::Material& material);
    Result<Texture> decode(int image);

    const tinygltf::Model& model_;
    Textures<int> textures_;               // by image
    std::map<int, std::uint32_t> number_;  // by material
    std::vector<Paint> paints_{Paint{}};
    std::vector<std::string> coordinates_{""};
    bool paint_ = false;
    std::vector<std::string> missing_;
};

}  // namespace mvw
