// Numbers in a glTF model's buffers, which tinygltf does not check.
#pragma once
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/result.h"

namespace mvw {

/// An accessor's numbers, checked to lie inside of its buffer.
struct Values {
    const unsigned char* data = nullptr;
    std::size_t count = 0, stride = 0, components = 0;
    std::size_t row = 0;  // bytes of one row's numbers
    int type = 0;
    bool normalized = false;

    [[nodiscard]] double at(std::size_t index, std::size_t component) const {
        const unsigned char* from = data + index * stride;
        switch (type) {
            case TINYGLTF_COMPONENT_TYPE_BYTE:
                return normalized ? std::max(load<std::int8_t>(from, component) / 127.0, -1.0)
                                  : load<std::int8_t>(from, component);
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                return load<std::uint8_t>(from, component) / (normalized ? 255.0 : 1.0);
            case TINYGLTF_COMPONENT_TYPE_SHORT:
                return normalized ? std::max(load<std::int16_t>(from, component) / 32767.0, -1.0)
                                  : load<std::int16_t>(from, component);
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                return load<std::uint16_t>(from, component) / (normalized ? 65535.0 : 1.0);
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
                return load<std::uint32_t>(from, component);
            default:
                return load<float>(from, component);
        }
    }

 private:
    template <typename T>
    static double load(const unsigned char* from, std::size_t component) {
        T value;
        std::memcpy(&value, from + component * sizeof(T), sizeof(T));
        return static_cast<double>(value);
    }
};

template <typename T>
bool in_range(int index, const std::vector<T>& list) {
    return index >= 0 && static_cast<std::size_t>(index) < list.size();
}

/// What an extension's object has under a key; null where it is no object or has none.
const tinygltf::Value& member_of(const tinygltf::Value& object, const std::string& name);
/// The same where it is an index, -1 else.
int index_of(const tinygltf::Value& object, const std::string& name);

/// Scalars and vectors of 2 to 4 numbers. Malformed where there is no such accessor, it is of another type or reaches
/// beyond its buffer. A sparse one's values are those before its changes (gltf_unpack.h makes them). The model must
/// outlive what is returned.
Result<Values> open_accessor(const tinygltf::Model& model, int index);
Result<Values> open_accessor(const tinygltf::Model& model, const tinygltf::Accessor& accessor, const std::string& name);
/// The bytes of a buffer view. Malformed likewise.
Result<ByteSpan> open_view(const tinygltf::Model& model, int index);

}  // namespace mvw
