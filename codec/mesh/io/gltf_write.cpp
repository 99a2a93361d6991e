// glTF 2.0 binary (.glb) through tinygltf: one mesh, one primitive for each material, one shared set of vertices.
// Surfaces of solids are one-sided, as everything in glTF is by default; others show both sides.
#include <tiny_gltf.h>

#include <cmath>
#include <exception>
#include <map>
#include <sstream>

#include "codec/mesh/io/formats.h"
#include "codec/mesh/io/text.h"
#include "codec/mesh/material_colors.h"
#include "codec/mesh/solid.h"
#include "codec/mesh/srgb.h"

namespace mvw {
namespace {

/// glTF colours are linear, ours sRGB; 16 bits keep all 256 steps apart.
std::uint16_t to_linear16(std::uint8_t channel) {
    return static_cast<std::uint16_t>(std::lround(65535 * to_linear(channel / 255.0)));
}

/// Builds the model's one buffer, a view and an accessor at a time.
class ModelBuilder {
 public:
    /// Index of an accessor over what `bytes` holds since byte `begin`.
    int add(std::size_t begin, int target, int component, int type, std::size_t count, bool normalized = false) {
        tinygltf::BufferView view;
        view.buffer = 0;
        view.byteOffset = begin;
        view.byteLength = bytes.size() - begin;
        view.target = target;
        model.bufferViews.push_back(view);
        tinygltf::Accessor accessor;
        accessor.bufferView = static_cast<int>(model.bufferViews.size()) - 1;
        accessor.componentType = component;
        accessor.type = type;
        accessor.count = count;
        accessor.normalized = normalized;
        model.accessors.push_back(accessor);
        return static_cast<int>(model.accessors.size()) - 1;
    }

    tinygltf::Model model;
    ByteWriter bytes;
};

/// Positions as float32, from `origin`. The accessor states their box, as the specification asks.
int add_positions(ModelBuilder& builder, const Mesh& mesh, const Vec3& origin) {
    const std::size_t begin = builder.bytes.size();
    Box box;
    for (const Vec3& p : mesh.positions) {
        const Vec3f q = to_float(p - origin);
        for (std::size_t k = 0; k < 3; ++k) builder.bytes.f32(q[k]);
        box.add(to_double(q));
    }
    const int index = builder.add(begin, TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                  TINYGLTF_TYPE_VEC3, mesh.positions.size());
    builder.model.accessors.back().minValues = {box.min.x, box.min.y, box.min.z};
    builder.model.accessors.back().maxValues = {box.max.x, box.max.y, box.max.z};
    return index;
}

int add_colors(ModelBuilder& builder, const Mesh& mesh) {
    const std::size_t begin = builder.bytes.size();
    for (const Rgba8& c : mesh.colors) {
        for (const std::uint8_t channel : {c.r, c.g, c.b}) builder.bytes.u16(to_linear16(channel));
        builder.bytes.u16(static_cast<std::uint16_t>(257 * c.a));
    }
    return builder.add(begin, TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4,
                       mesh.colors.size(), true);
}

int add_field(ModelBuilder& builder, const VertexField& field) {
    const std::size_t begin = builder.bytes.size();
    for (const double x : field.values) builder.bytes.f32(static_cast<float>(x));
    return builder.add(begin, TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT,
                       field.kind == FieldKind::Normals ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_SCALAR,
                       field.values.size() / field.components());
}

int add_indices(ModelBuilder& builder, const Mesh& mesh, const std::vector<std::size_t>& faces) {
    const std::size_t begin = builder.bytes.size();
    for (const std::size_t f : faces)
        for (const std::uint32_t v : mesh.faces[f]) builder.bytes.u32(v);
    return builder.add(begin, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                       TINYGLTF_TYPE_SCALAR, 3 * faces.size());
}

/// Faces by material label, in order of label; one list where there are no labels.
std::map<std::uint32_t, std::vector<std::size_t>> faces_by_material(const Mesh& mesh) {
    std::map<std::uint32_t, std::vector<std::size_t>> groups;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        groups[mesh.materials.empty() ? 0 : mesh.materials[f]].push_back(f);
    return groups;
}

}  // namespace

Result<Bytes> write_glb(const Mesh& mesh) {
    ModelBuilder builder;
    tinygltf::Node node;
    node.mesh = 0;
    Vec3 origin;
    if (needs_double(mesh)) {
        origin = bounding_box(mesh).center();
        node.translation = {origin.x, origin.y, origin.z};
    }
    tinygltf::Primitive vertices;
    vertices.mode = TINYGLTF_MODE_TRIANGLES;
    vertices.attributes["POSITION"] = add_positions(builder, mesh, origin);
    if (!mesh.colors.empty()) vertices.attributes["COLOR_0"] = add_colors(builder, mesh);
    for (const VertexField& field : mesh.fields)
        vertices.attributes[field.kind == FieldKind::Normals ? "NORMAL" : "_" + field.name] = add_field(builder, field);
    tinygltf::Mesh shape;
    const bool two_sided = !bounds_solids(mesh);  // viewers leave backs out otherwise
    for (const auto& [label, faces] : faces_by_material(mesh)) {
        tinygltf::Primitive primitive = vertices;
        primitive.indices = add_indices(builder, mesh, faces);
        const Rgba8* color = color_of(mesh.material_colors, label);
        if (!mesh.materials.empty() || two_sided || color != nullptr) {
            tinygltf::Material material;
            if (!mesh.materials.empty()) material.name = "material_" + std::to_string(label);
            material.doubleSided = two_sided;
            if (color != nullptr) {
                const std::array<double, 4> factor = to_linear(*color);
                material.pbrMetallicRoughness.baseColorFactor.assign(factor.begin(), factor.end());
                if (color->a < 255) material.alphaMode = "BLEND";
                primitive.attributes.erase("COLOR_0");  // of other materials
            }
            builder.model.materials.push_back(material);
            primitive.material = static_cast<int>(builder.model.materials.size()) - 1;
        }
        shape.primitives.push_back(primitive);
    }

    tinygltf::Model& model = builder.model;
    model.asset.version = "2.0";
    model.meshes.push_back(shape);
    model.nodes.push_back(node);
    model.scenes.emplace_back().nodes = {0};
    model.defaultScene = 0;
    const Bytes& bytes = builder.bytes.view();
    const auto* begin = reinterpret_cast<const unsigned char*>(bytes.data());
    model.buffers.emplace_back().data.assign(begin, begin + bytes.size());
    std::ostringstream stream;
    try {
        if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, stream, false, true))
            return Error{Errc::LimitExceeded, 0, "cannot be written as glTF"};
    } catch (const std::exception& failure) {
        return Error{Errc::LimitExceeded, 0, std::string("cannot be written as glTF: ") + failure.what()};
    }
    const std::string text = stream.str();
    const ByteSpan written = as_bytes(text);
    return Bytes(written.begin(), written.end());
}

}  // namespace mvw
