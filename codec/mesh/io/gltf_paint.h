// Base colours of glTF materials: a factor, and an image or none.
#pragma once
#include <tiny_gltf.h>

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "codec/mesh/io/texture.h"

namespace mvw {

struct GltfPaint {
    std::array<double, 4> factor{1, 1, 1, 1};  // linear, and alpha
    std::shared_ptr<const Texture> texture;
    Texture::Wrap across = Texture::Wrap::Repeat, down = Texture::Wrap::Repeat;
    std::string coordinates = "TEXCOORD_0";  // the attribute that says where in the image a vertex lies
    // KHR_texture_transform: first scale, then turn, then offset.
    std::array<double, 2> offset{}, scale{1, 1};
    double turn = 0;

    [[nodiscard]] std::array<double, 4> at(double u, double v) const;
};

/// The paints of all materials that primitives use.
class GltfPaints {
 public:
    /// Images are decoded, those of the model's files too; the model must outlive this.
    explicit GltfPaints(const tinygltf::Model& model);

    /// Whether any has an image.
    [[nodiscard]] bool any_texture() const;
    /// Of a primitive's material; white where it has none.
    [[nodiscard]] const GltfPaint& of(int material) const;
    /// Images that could not be read, and why.
    [[nodiscard]] const std::vector<std::string>& missing() const { return missing_; }

 private:
    GltfPaint paint_of(const tinygltf::Material& material);
    Result<Texture> decode(int image);

    const tinygltf::Model& model_;
    Textures<int> textures_;  // by image
    std::map<int, GltfPaint> paints_;
    GltfPaint white_;
    std::vector<std::string> missing_;
};

}  // namespace mvw
