#include "codec/mesh/io/gltf_meshopt.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <span>

#include "codec/mesh/io/errors.h"
#include "codec/mesh/io/gltf_accessor.h"

namespace mvw {
namespace {

constexpr std::uint64_t kMostBesides = 4096;  // what a stream's last block may hold besides, at most 256 bytes a row

std::size_t number_of(const tinygltf::Value& extension, const char* name) {
    return static_cast<std::size_t>(std::max(0, index_of(extension, name)));
}

std::string word_of(const tinygltf::Value& extension, const char* name) {
    const tinygltf::Value& value = member_of(extension, name);
    return value.IsString() ? value.Get<std::string>() : std::string();
}

/// What meshoptimizer would assert.
bool is_known(const PackedView& packed) {
    const std::size_t stride = packed.stride;
    const bool mode = packed.mode == "ATTRIBUTES"  ? stride % 4 == 0 && stride >= 4 && stride <= 256
                      : packed.mode == "TRIANGLES" ? (stride == 2 || stride == 4) && packed.count % 3 == 0
                                                   : (stride == 2 || stride == 4) && packed.mode == "INDICES";
    const bool filter = packed.filter == "OCTAHEDRAL"    ? stride == 4 || stride == 8
                        : packed.filter == "QUATERNION"  ? stride == 8
                        : packed.filter == "EXPONENTIAL" ? stride % 4 == 0
                                                         : packed.filter.empty() || packed.filter == "NONE";
    return mode && filter;
}

}  // namespace

Result<PackedView> packed_view_of(const tinygltf::Model& model, const tinygltf::Value& extension) {
    const int buffer = index_of(extension, "buffer");
    if (!in_range(buffer, model.buffers)) return malformed("has no packed bytes");
    const ByteSpan all = std::as_bytes(std::span(model.buffers[static_cast<std::size_t>(buffer)].data));
    const std::size_t offset = number_of(extension, "byteOffset"), length = number_of(extension, "byteLength");
    if (offset > all.size() || length > all.size() - offset) return malformed("is packed beyond its buffer");
    PackedView packed{all.subspan(offset, length), number_of(extension, "count"), number_of(extension, "byteStride"),
                      word_of(extension, "mode"), word_of(extension, "filter")};
    if (!is_known(packed)) return malformed("is packed in a way that its extension does not know");
    if (packed.count * packed.stride > kMostMeshoptPerByte * length + kMostBesides)
        return Error{Errc::LimitExceeded, 0, "would unpack to more than its bytes can hold"};
    return packed;
}

Result<std::vector<unsigned char>> unpack_view(const PackedView& packed) {
    std::vector<unsigned char> out(packed.count * packed.stride);
    const auto* bytes = reinterpret_cast<const unsigned char*>(packed.bytes.data());
    const std::size_t size = packed.bytes.size();
    const int fault = packed.mode == "ATTRIBUTES"
                          ? meshopt_decodeVertexBuffer(out.data(), packed.count, packed.stride, bytes, size)
                      : packed.mode == "TRIANGLES"
                          ? meshopt_decodeIndexBuffer(out.data(), packed.count, packed.stride, bytes, size)
                          : meshopt_decodeIndexSequence(out.data(), packed.count, packed.stride, bytes, size);
    if (fault != 0) return malformed("is refused by meshoptimizer");
    const auto filter = packed.filter == "OCTAHEDRAL"    ? meshopt_decodeFilterOct
                        : packed.filter == "QUATERNION"  ? meshopt_decodeFilterQuat
                        : packed.filter == "EXPONENTIAL" ? meshopt_decodeFilterExp
                                                         : nullptr;
    if (filter != nullptr) filter(out.data(), packed.count, packed.stride);
    return out;
}

}  // namespace mvw
