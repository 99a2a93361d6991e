// The streams of glTF's KHR_draco_mesh_compression.
#pragma once
#include <map>
#include <vector>

#include "codec/bytes.h"
#include "codec/result.h"

namespace mvw {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// Rows of numbers as a glTF buffer holds them.
struct PlainRows {
    std::vector<unsigned char> bytes;
    int component_type = 0, type = 0;  // tinygltf's; 0 where glTF has no such rows
    std::size_t count = 0;
};

/// One stream: the corners of its triangles, and its attributes by their unique id, a row for each point.
struct DracoRows {
    PlainRows corners;
    std::map<int, PlainRows> attributes;
};

/// Malformed where the stream is damaged, no triangle mesh, or says that it has more faces or vertices than its bytes
/// can hold (checked before Draco allocates; what its attributes take is Draco's to bound); Unsupported where it is not
/// of bitstream 2.2, glTF's only one. Errors name no view.
Result<DracoRows> decode_gltf_draco(ByteSpan stream);

}  // namespace mvw
