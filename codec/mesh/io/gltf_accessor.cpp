#include "codec/mesh/io/gltf_accessor.h"

#include <fmt/format.h>

namespace mvw {
namespace {

Error malformed(std::string reason) {
    return {Errc::Malformed, 0, std::move(reason)};
}

std::size_t component_bytes(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

std::size_t components_of(int type) {
    switch (type) {
        case TINYGLTF_TYPE_SCALAR:
            return 1;
        case TINYGLTF_TYPE_VEC2:
            return 2;
        case TINYGLTF_TYPE_VEC3:
            return 3;
        case TINYGLTF_TYPE_VEC4:
            return 4;
        default:
            return 0;
    }
}

}  // namespace

Result<Values> open_accessor(const tinygltf::Model& model, int index) {
    if (!in_range(index, model.accessors)) return malformed(fmt::format("there is no accessor {}", index));
    const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(index)];
    if (accessor.sparse.isSparse) return Error{Errc::Unsupported, 0, "uses sparse accessors, which are not known"};
    if (!in_range(accessor.bufferView, model.bufferViews))
        return malformed(fmt::format("accessor {} has no data", index));
    const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
    if (!in_range(view.buffer, model.buffers))
        return malformed(fmt::format("buffer view {} has no buffer", accessor.bufferView));
    const std::vector<unsigned char>& buffer = model.buffers[static_cast<std::size_t>(view.buffer)].data;

    Values values;
    values.type = accessor.componentType;
    values.normalized = accessor.normalized;
    values.count = accessor.count;
    values.components = components_of(accessor.type);
    const std::size_t row = values.components * component_bytes(values.type);
    values.stride = view.byteStride == 0 ? row : view.byteStride;
    if (row == 0) return malformed(fmt::format("accessor {} is of an unexpected type", index));
    // Each term is compared before it is used, so that no sum can overflow.
    const bool inside = view.byteOffset <= buffer.size() && view.byteLength <= buffer.size() - view.byteOffset &&
                        accessor.byteOffset <= view.byteLength && values.stride <= 252 &&
                        (values.count == 0 || row <= view.byteLength - accessor.byteOffset) &&
                        (values.count <= 1 || values.count - 1 <= (view.byteLength - accessor.byteOffset - row) /
                                                                      std::max<std::size_t>(1, values.stride));
    if (!inside) return malformed(fmt::format("accessor {} reaches beyond its buffer", index));
    values.data = buffer.data() + view.byteOffset + accessor.byteOffset;
    return values;
}

Result<ByteSpan> open_view(const tinygltf::Model& model, int index) {
    if (!in_range(index, model.bufferViews)) return malformed(fmt::format("there is no buffer view {}", index));
    const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(index)];
    if (!in_range(view.buffer, model.buffers)) return malformed(fmt::format("buffer view {} has no buffer", index));
    const std::vector<unsigned char>& buffer = model.buffers[static_cast<std::size_t>(view.buffer)].data;
    if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset)
        return malformed(fmt::format("buffer view {} reaches beyond its buffer", index));
    return std::as_bytes(std::span(buffer)).subspan(view.byteOffset, view.byteLength);
}

}  // namespace mvw
