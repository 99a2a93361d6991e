#include "codec/mesh/io/gltf_draco.h"

#include <draco/compression/decode.h>
#include <draco/metadata/metadata_decoder.h>
#include <tiny_gltf.h>

#include <array>
#include <exception>
#include <memory>
#include <string>

#include "codec/mesh/io/errors.h"

namespace mvw {
namespace {

constexpr std::uint64_t kMaxFacesPerByte = 256;  // a flat grid of 700 by 700 vertices has 28
constexpr unsigned kTriangleMesh = 1, kEdgebreaker = 1, kHasMetadata = 0x8000;

draco::DecoderBuffer buffer_of(ByteSpan bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return buffer;
}

/// From the bytes behind the head and metadata, in Draco's order.
Result<void> check_counts(ByteSpan body, bool edgebreaker) {
    ByteReader in(body);
    if (edgebreaker) in.u8();  // traversal method
    const std::uint64_t first = in.varint(), second = in.varint();
    const std::uint64_t faces = edgebreaker ? second : first, vertices = edgebreaker ? first : second;
    if (!in.ok() || faces > kMaxFacesPerByte * body.size() || vertices > 3 * faces)
        return malformed("holds a Draco stream of more faces or vertices than its bytes can hold");
    return {};
}

/// Everything of the stream's beginning that Draco would believe.
Result<void> check_head(ByteSpan stream) {
    ByteReader in(stream);
    std::string magic;
    for (int k = 0; k < 5; ++k) magic += static_cast<char>(in.u8());
    const unsigned major = in.u8(), minor = in.u8(), kind = in.u8(), method = in.u8(), flags = in.u16();
    if (!in.ok() || magic != "DRACO") return malformed("holds no Draco stream");
    if (major != 2 || minor != 2) return Error{Errc::Unsupported, 0, "is not of Draco's bitstream 2.2"};
    if (kind != kTriangleMesh || method > kEdgebreaker) return malformed("holds no triangle mesh of Draco");
    ByteSpan body = in.bytes(in.remaining());
    if ((flags & kHasMetadata) != 0) {
        draco::DecoderBuffer buffer = buffer_of(body);
        draco::GeometryMetadata metadata;
        if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata))
            return malformed("has damaged Draco metadata");
        body = body.last(static_cast<std::size_t>(buffer.remaining_size()));
    }
    return check_counts(body, method == kEdgebreaker);
}

Result<std::unique_ptr<draco::Mesh>> run_draco(ByteSpan stream) {
    draco::DecoderBuffer buffer = buffer_of(stream);
    draco::Decoder decoder;
    try {
        auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
        if (mesh.ok()) return std::move(mesh).value();
        return malformed("is refused by Draco: " + mesh.status().error_msg_string());
    } catch (const std::exception&) {  // an allocation that Draco should not have tried
        return malformed("is refused by Draco");
    }
}

int component_type_of(draco::DataType type) {
    switch (type) {
        case draco::DT_INT8:
            return TINYGLTF_COMPONENT_TYPE_BYTE;
        case draco::DT_UINT8:
            return TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
        case draco::DT_INT16:
            return TINYGLTF_COMPONENT_TYPE_SHORT;
        case draco::DT_UINT16:
            return TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
        case draco::DT_UINT32:
            return TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        case draco::DT_FLOAT32:
            return TINYGLTF_COMPONENT_TYPE_FLOAT;
        default:
            return 0;
    }
}

int type_of(std::size_t components) {
    constexpr std::array kTypes{0, TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
    return components < kTypes.size() ? kTypes[components] : 0;
}

PlainRows corners_of(const draco::Mesh& mesh) {
    PlainRows rows{{}, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, 3 * std::size_t{mesh.num_faces()}};
    rows.bytes.reserve(rows.count * sizeof(std::uint32_t));
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
        for (const draco::PointIndex& point : mesh.face(f)) {
            const std::uint32_t value = point.value();
            const auto* bytes = reinterpret_cast<const unsigned char*>(&value);
            rows.bytes.insert(rows.bytes.end(), bytes, bytes + sizeof value);
        }
    }
    return rows;
}

PlainRows rows_of(const draco::PointAttribute& attribute, std::size_t points) {
    const auto components = static_cast<std::size_t>(attribute.num_components());
    PlainRows rows{{}, component_type_of(attribute.data_type()), type_of(components), points};
    if (rows.component_type == 0 || rows.type == 0) return rows;
    const std::size_t row = components * static_cast<std::size_t>(draco::DataTypeLength(attribute.data_type()));
    rows.bytes.resize(row * points);
    for (std::size_t p = 0; p < points; ++p)
        attribute.GetMappedValue(draco::PointIndex(static_cast<std::uint32_t>(p)), &rows.bytes[row * p]);
    return rows;
}

}  // namespace

Result<DracoRows> decode_gltf_draco(ByteSpan stream) {
    if (const auto fine = check_head(stream); !fine) return fine.error();
    const Result<std::unique_ptr<draco::Mesh>> mesh = run_draco(stream);
    if (!mesh) return mesh.error();
    DracoRows out;
    out.corners = corners_of(**mesh);
    for (int a = 0; a < (*mesh)->num_attributes(); ++a) {
        const draco::PointAttribute& attribute = *(*mesh)->attribute(a);
        out.attributes[static_cast<int>(attribute.unique_id())] = rows_of(attribute, (*mesh)->num_points());
    }
    return out;
}

}  // namespace mvw
