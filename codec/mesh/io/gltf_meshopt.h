// The packed buffer views of glTF's EXT_meshopt_compression.
#pragma once
#include <tiny_gltf.h>

#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/result.h"

namespace mvw {

inline constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";
/// A byte of these streams never unpacks to more.
inline constexpr std::uint64_t kMostMeshoptPerByte = 64;

/// A view's extension: where its packed bytes are, and how many rows they hold.
struct PackedView {
    ByteSpan bytes;
    std::size_t count = 0, stride = 0;
    std::string mode, filter;

    [[nodiscard]] bool indices() const { return mode != "ATTRIBUTES"; }
};

/// Malformed where it names bytes that there are not or a way of packing that the extension has not; LimitExceeded
/// where it names more rows than the bytes can hold. Errors name no view.
Result<PackedView> packed_view_of(const tinygltf::Model& model, const tinygltf::Value& extension);
/// count * stride bytes. Malformed where the bytes are damaged.
Result<std::vector<unsigned char>> unpack_view(const PackedView& packed);

}  // namespace mvw
