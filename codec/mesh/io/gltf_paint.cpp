#include "codec/mesh/io/gltf_paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "codec/mesh/io/gltf_accessor.h"

namespace mvw {
namespace {

Texture::Wrap wrap_of(int mode) {
    return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Texture::Wrap::Clamp
           : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Texture::Wrap::Mirror
                                                           : Texture::Wrap::Repeat;
}

std::array<double, 2> pair_of(const tinygltf::Value& object, const char* name, std::array<double, 2> otherwise) {
    const tinygltf::Value& list = object.Get(name);
    if (!list.IsArray() || list.ArrayLen() != 2 || !list.Get(0).IsNumber() || !list.Get(1).IsNumber()) return otherwise;
    return {list.Get(0).GetNumberAsDouble(), list.Get(1).GetNumberAsDouble()};
}

/// EXT_texture_webp's image goes before the one for those who cannot read it.
int image_of(const tinygltf::Texture& texture) {
    const auto webp = texture.extensions.find("EXT_texture_webp");
    const int source = webp != texture.extensions.end() ? index_of(webp->second, "source") : -1;
    if (source >= 0 || texture.source >= 0) return source >= 0 ? source : texture.source;
    const auto basis = texture.extensions.find("KHR_texture_basisu");
    return basis != texture.extensions.end() ? index_of(basis->second, "source") : -1;
}

/// KHR_texture_transform: first scale, then turn, then offset.
void take_transform(const tinygltf::Value& transform, Paint& paint, std::string& coordinates) {
    if (!transform.IsObject()) return;
    const std::array<double, 2> offset = pair_of(transform, "offset", {0, 0}),
                                scale = pair_of(transform, "scale", {1, 1});
    const double turn = transform.Get("rotation").IsNumber() ? transform.Get("rotation").GetNumberAsDouble() : 0;
    const double c = std::cos(turn), s = std::sin(turn);
    paint.place = {{{c * scale[0], s * scale[1], offset[0]}, {-s * scale[0], c * scale[1], offset[1]}}};
    if (transform.Get("texCoord").IsInt())
        coordinates = "TEXCOORD_" + std::to_string(transform.Get("texCoord").GetNumberAsInt());
}

}  // namespace

GltfPaints::GltfPaints(const tinygltf::Model& model) : model_(model) {
    bool any_without = false;
    for (const tinygltf::Mesh& mesh : model.meshes)
        for (const tinygltf::Primitive& primitive : mesh.primitives) {
            any_without = any_without || !in_range(primitive.material, model.materials);
            if (in_range(primitive.material, model.materials) && !number_.contains(primitive.material)) {
                number_.emplace(primitive.material, static_cast<std::uint32_t>(paints_.size()));
                add(model.materials[static_cast<std::size_t>(primitive.material)]);
            }
        }
    paint_ = !are_plain(std::span(paints_).subspan(any_without || paints_.size() == 1 ? 0 : 1));
}

std::uint32_t GltfPaints::number_of(int material) const {
    const auto known = number_.find(material);
    return known != number_.end() ? known->second : 0;
}

void GltfPaints::add(const tinygltf::Material& material) {
    Paint& paint = paints_.emplace_back();
    std::string& coordinates = coordinates_.emplace_back();
    const tinygltf::PbrMetallicRoughness& pbr = material.pbrMetallicRoughness;
    paint.opaque = material.alphaMode != "BLEND" && material.alphaMode != "MASK";
    if (pbr.baseColorFactor.size() == 4)
        for (std::size_t k = 0; k < (paint.opaque ? 3u : 4u); ++k)
            paint.color[k] = std::clamp(pbr.baseColorFactor[k], 0.0, 1.0);
    if (!in_range(pbr.baseColorTexture.index, model_.textures)) return;
    const tinygltf::Texture& texture = model_.textures[static_cast<std::size_t>(pbr.baseColorTexture.index)];
    const int image = image_of(texture);
    paint.texture = textures_.get(
        image, "image " + std::to_string(image), [&] { return decode(image); }, missing_);
    coordinates = "TEXCOORD_" + std::to_string(pbr.baseColorTexture.texCoord);
    if (in_range(texture.sampler, model_.samplers)) {
        const tinygltf::Sampler& sampler = model_.samplers[static_cast<std::size_t>(texture.sampler)];
        paint.across = wrap_of(sampler.wrapS);
        paint.down = wrap_of(sampler.wrapT);
    }
    const auto& extensions = pbr.baseColorTexture.extensions;
    if (const auto found = extensions.find("KHR_texture_transform"); found != extensions.end())
        take_transform(found->second, paint, coordinates);
}

Result<Texture> GltfPaints::decode(int image) {
    if (!in_range(image, model_.images)) return Error{Errc::Malformed, 0, "is not in the file"};
    const tinygltf::Image& source = model_.images[static_cast<std::size_t>(image)];
    if (source.bufferView < 0) return Texture::decode(std::as_bytes(std::span(source.image)));
    const Result<ByteSpan> bytes = open_view(model_, source.bufferView);
    return bytes ? Texture::decode(*bytes) : Result<Texture>(bytes.error());
}

}  // namespace mvw
