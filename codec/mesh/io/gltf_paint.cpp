#include "codec/mesh/io/gltf_paint.h"

#include <algorithm>
#include <cmath>

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

void take_transform(const tinygltf::Value& transform, GltfPaint& paint) {
    if (!transform.IsObject()) return;
    paint.offset = pair_of(transform, "offset", paint.offset);
    paint.scale = pair_of(transform, "scale", paint.scale);
    if (transform.Get("rotation").IsNumber()) paint.turn = transform.Get("rotation").GetNumberAsDouble();
    if (transform.Get("texCoord").IsInt())
        paint.coordinates = "TEXCOORD_" + std::to_string(transform.Get("texCoord").GetNumberAsInt());
}

}  // namespace

std::array<double, 4> GltfPaint::at(double u, double v) const {
    std::array<double, 4> out = factor;
    if (!texture) return out;
    const double x = u * scale[0], y = v * scale[1], c = std::cos(turn), s = std::sin(turn);
    const std::array<double, 4> texel = texture->at(c * x + s * y + offset[0], c * y - s * x + offset[1], across, down);
    for (std::size_t k = 0; k < 4; ++k) out[k] *= texel[k];
    return out;
}

GltfPaints::GltfPaints(const tinygltf::Model& model) : model_(model) {
    for (const tinygltf::Mesh& mesh : model.meshes)
        for (const tinygltf::Primitive& primitive : mesh.primitives)
            if (in_range(primitive.material, model.materials) && !paints_.contains(primitive.material))
                paints_.emplace(primitive.material,
                                paint_of(model.materials[static_cast<std::size_t>(primitive.material)]));
}

bool GltfPaints::any_texture() const {
    return std::ranges::any_of(paints_, [](const auto& entry) { return entry.second.texture != nullptr; });
}

const GltfPaint& GltfPaints::of(int material) const {
    const auto known = paints_.find(material);
    return known != paints_.end() ? known->second : white_;
}

GltfPaint GltfPaints::paint_of(const tinygltf::Material& material) {
    GltfPaint paint;
    const tinygltf::PbrMetallicRoughness& pbr = material.pbrMetallicRoughness;
    if (pbr.baseColorFactor.size() == 4) std::ranges::copy(pbr.baseColorFactor, paint.factor.begin());
    if (!in_range(pbr.baseColorTexture.index, model_.textures)) return paint;
    const tinygltf::Texture& texture = model_.textures[static_cast<std::size_t>(pbr.baseColorTexture.index)];
    paint.texture = textures_.get(
        texture.source, "image " + std::to_string(texture.source), [&] { return decode(texture.source); }, missing_);
    paint.coordinates = "TEXCOORD_" + std::to_string(pbr.baseColorTexture.texCoord);
    if (in_range(texture.sampler, model_.samplers)) {
        const tinygltf::Sampler& sampler = model_.samplers[static_cast<std::size_t>(texture.sampler)];
        paint.across = wrap_of(sampler.wrapS);
        paint.down = wrap_of(sampler.wrapT);
    }
    const auto& extensions = pbr.baseColorTexture.extensions;
    if (const auto found = extensions.find("KHR_texture_transform"); found != extensions.end())
        take_transform(found->second, paint);
    return paint;
}

Result<Texture> GltfPaints::decode(int image) {
    if (!in_range(image, model_.images)) return Error{Errc::Malformed, 0, "is not in the file"};
    const tinygltf::Image& source = model_.images[static_cast<std::size_t>(image)];
    if (source.bufferView < 0) return Texture::decode(std::as_bytes(std::span(source.image)));
    const Result<ByteSpan> bytes = open_view(model_, source.bufferView);
    return bytes ? Texture::decode(*bytes) : Result<Texture>(bytes.error());
}

}  // namespace mvw
