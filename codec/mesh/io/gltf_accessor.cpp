#include "codec/mesh/io/gltf_accessor.h"

#include <fmt/format.h>

#include "codec/mesh/io/errors.h"

namespace mvw {
namespace {

constexpr std::size_t kMaxStride = 256;

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

const tinygltf::Value& member_of(const tinygltf::Value& object, const std::string& name) {
    static const tinygltf::Value null;
    return object.Has(name) ? object.Get(name) : null;
}

int index_of(const tinygltf::Value& object, const std::string& name) {
    const tinygltf::Value& index = member_of(object, name);
    return index.IsInt() ? index.GetNumberAsInt() : -1;
}

Result<Values> open_accessor(const tinygltf::Model& model, int index) {
    if (!in_range(index, model.accessors)) return malformed(fmt::format("there is no accessor {}", index));
    return open_accessor(model, model.accessors[static_cast<std::size_t>(index)], fmt::format("accessor {}", index));
}

Result<Values> open_accessor(const tinygltf::Model& model, const tinygltf::Accessor& accessor,
                             const std::string& name) {
    if (!in_range(accessor.bufferView, model.bufferViews)) return malformed(name + " has no data");
    const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
    if (!in_range(view.buffer, model.buffers))
        return malformed(fmt::format("buffer view {} has no buffer", accessor.bufferView));
    const std::vector<unsigned char>& buffer = model.buffers[static_cast<std::size_t>(view.buffer)].data;

    Values values;
    values.type = accessor.componentType;
    values.normalized = accessor.normalized;
    values.count = accessor.count;
    values.components = components_of(accessor.type);
    values.row = values.components * component_bytes(values.type);
    values.stride = view.byteStride == 0 ? values.row : view.byteStride;
    if (values.row == 0) return malformed(name + " is of an unexpected type");
    // Each term is compared before it is used, so that no sum can overflow.
    const bool inside = view.byteOffset <= buffer.size() && view.byteLength <= buffer.size() - view.byteOffset &&
                        accessor.byteOffset <= view.byteLength && values.stride <= kMaxStride &&
                        (values.count == 0 || values.row <= view.byteLength - accessor.byteOffset) &&
                        (values.count <= 1 || values.count - 1 <= (view.byteLength - accessor.byteOffset - values.row) /
                                                                      std::max<std::size_t>(1, values.stride));
    if (!inside) return malformed(name + " reaches beyond its buffer");
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
