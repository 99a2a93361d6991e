#include "codec/mesh/io/mesh_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "codec/mesh/io/files.h"
#include "codec/mesh/io/formats.h"
#include "codec/mesh/material_colors.h"

namespace mvw {
namespace {

constexpr std::array<const char*, 7> kEndings{".ply", ".obj", ".stl", ".off", ".gltf", ".glb", ".3mf"};

Error unknown_format(const std::string& path) {
    return {Errc::InvalidArgument, 0,
            path + ": has no known mesh format's ending (.ply .obj .stl .off .gltf .glb .3mf)"};
}

Error of_file(const std::string& path, Error error) {
    error.message = path + ": " + error.message;
    return error;
}

Result<Polygons> read_polygons(ByteSpan bytes, MeshFormat format, const Surroundings& around) {
    switch (format) {
        case MeshFormat::Ply:
            return read_ply(bytes);
        case MeshFormat::Obj:
            return read_obj(bytes, around);
        case MeshFormat::Stl:
            return read_stl(bytes);
        case MeshFormat::Off:
            return read_off(bytes);
        case MeshFormat::Gltf:
        case MeshFormat::Glb:
            return read_gltf(bytes, format == MeshFormat::Glb, around);
        case MeshFormat::ThreeMf:
            return read_3mf(bytes);
    }
    return Error{Errc::InvalidArgument, 0, "is of no known format"};
}

Result<Mesh> read_bytes(ByteSpan bytes, MeshFormat format, const Surroundings& around, CleanReport& report) {
    if (bytes.empty()) return Error{Errc::Malformed, 0, "is empty"};
    Result<Polygons> polygons = read_polygons(bytes, format, around);
    if (!polygons) return polygons.error();
    return to_mesh(std::move(polygons).value(), report);
}

bool fits_float(const Mesh& mesh) {
    constexpr double kMost = std::numeric_limits<float>::max();
    return std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Vec3& p) {
        return std::abs(p.x) <= kMost && std::abs(p.y) <= kMost && std::abs(p.z) <= kMost;
    });
}

}  // namespace

bool needs_double(const Mesh& mesh) {
    const double allowed = 1e-6 * bounding_box(mesh).diagonal();
    return std::any_of(mesh.positions.begin(), mesh.positions.end(),
                       [&](const Vec3& p) { return !(length(p - to_double(to_float(p))) <= allowed); });
}

const VertexField* normals_of(const Mesh& mesh) {
    const auto found = std::ranges::find(mesh.fields, FieldKind::Normals, &VertexField::kind);
    return found != mesh.fields.end() ? &*found : nullptr;
}

std::vector<std::string> left_out_by(MeshFormat format, const Mesh& mesh) {
    const bool everything = format == MeshFormat::Ply || format == MeshFormat::Glb || format == MeshFormat::Gltf;
    std::vector<std::string> names;
    if ((!mesh.colors.empty() || !mesh.material_colors.empty()) && format == MeshFormat::Stl)
        names.emplace_back("color");
    for (const VertexField& field : mesh.fields)
        if (field.kind == FieldKind::Scalar ? !everything : !everything && format != MeshFormat::Obj)
            names.push_back(field.kind == FieldKind::Scalar ? field.name : "normal");
    return names;
}

bool needs_double(const VertexField& field) {
    if (field.kind == FieldKind::Normals || field.values.empty()) return false;
    const auto [least, most] = std::ranges::minmax(field.values);
    const double allowed = 1e-6 * (most - least);
    return std::ranges::any_of(
        field.values, [&](double x) { return !(std::abs(x - static_cast<double>(static_cast<float>(x))) <= allowed); });
}

std::optional<MeshFormat> mesh_format_of(const std::string& path) {
    const std::size_t dot = path.find_last_of("./");
    if (dot == std::string::npos) return {};
    std::string ending = path.substr(dot);
    for (char& c : ending)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
    for (std::size_t i = 0; i < kEndings.size(); ++i)
        if (ending == kEndings[i]) return static_cast<MeshFormat>(i);
    return {};
}

bool can_write_mesh(const std::string& path) {
    const auto format = mesh_format_of(path);
    return format && format != MeshFormat::Gltf && format != MeshFormat::ThreeMf;
}

Result<Mesh> read_mesh_from_memory(ByteSpan bytes, MeshFormat format, CleanReport& report) {
    return read_bytes(bytes, format, {}, report);
}

Result<Mesh> read_mesh(const std::string& path, CleanReport& report, const std::string& texture) {
    const auto format = mesh_format_of(path);
    if (!format) return unknown_format(path);
    const Result<Bytes> bytes = read_file(path);
    if (!bytes) return bytes.error();
    const std::string folder = path.find('/') == std::string::npos ? "./" : path.substr(0, path.rfind('/') + 1);
    Result<Bytes> image = texture.empty() ? Result<Bytes>(Bytes{}) : read_file(texture);
    if (!image) return image.error();
    Result<Mesh> mesh = read_bytes(*bytes, *format, {&folder, *image}, report);
    if (!mesh) return of_file(path, mesh.error());
    return mesh;
}

Result<Bytes> write_mesh_to_memory(const Mesh& mesh, MeshFormat format) {
    if ((format == MeshFormat::Stl || format == MeshFormat::Glb) && !fits_float(mesh))
        return Error{Errc::InvalidArgument, 0, "coordinates are too large for this format's 32 bits"};
    const bool keeps_materials = format == MeshFormat::Glb || format == MeshFormat::Stl;
    if (!keeps_materials && !mesh.material_colors.empty()) {
        Mesh split = mesh;
        (void)colors_to_vertices(split);
        return write_mesh_to_memory(split, format);
    }
    switch (format) {
        case MeshFormat::Ply:
            return write_ply(mesh);
        case MeshFormat::Obj:
            return write_obj(mesh);
        case MeshFormat::Stl:
            return write_stl(mesh);
        case MeshFormat::Off:
            return write_off(mesh);
        case MeshFormat::Glb:
            return write_glb(mesh);
        case MeshFormat::Gltf:
        case MeshFormat::ThreeMf:
            break;
    }
    return Error{Errc::Unsupported, 0, "cannot be written as .gltf or .3mf: use .glb"};
}

Result<void> write_mesh(const std::string& path, const Mesh& mesh) {
    const auto format = mesh_format_of(path);
    if (!format) return unknown_format(path);
    const Result<Bytes> bytes = write_mesh_to_memory(mesh, *format);
    if (!bytes) return of_file(path, bytes.error());
    return write_file(path, *bytes);
}

}  // namespace mvw
