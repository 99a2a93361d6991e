#include "codec/dec_base.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <memory>
#include <string>

#include "codec/entropy/dec_bits.h"
#include "codec/entropy/model_coder.h"
#include "codec/labels.h"

namespace mvw {

namespace {

Error malformed(std::string message) {
    return {Errc::Malformed, 0, std::move(message)};
}

/// The counts that Draco's decoder will believe, read as it reads them (bitstream 2.2).
Result<void> check_draco_counts(ByteSpan bytes, bool sequential, std::uint32_t vertices, std::uint32_t faces) {
    ByteReader in(bytes);
    std::uint64_t v = 0, f = 0;
    if (sequential) {
        f = in.varint();
        v = in.varint();
    } else {
        in.u8();  // traversal method
        v = in.varint();
        f = in.varint();
    }
    if (!in.ok() || f != faces || v > vertices) return malformed("the base's counts are not the header's");
    if (faces > kMaxFacesPerByte * bytes.size()) return malformed("the base has more faces than its bytes can hold");
    return {};
}

std::unique_ptr<draco::Mesh> run_draco(ByteSpan bytes, bool sequential) {
    // "DRACO", bitstream 2.2, triangle mesh, method, no flags: the same in every file, so not stored.
    Bytes stream;
    for (const unsigned b : {0x44u, 0x52u, 0x41u, 0x43u, 0x4Fu, 2u, 2u, 1u, sequential ? 0u : 1u, 0u, 0u})
        stream.push_back(static_cast<std::byte>(b));
    stream.insert(stream.end(), bytes.begin(), bytes.end());
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
    draco::Decoder decoder;
#if defined(__cpp_exceptions)
    try {
#endif
        auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
        return mesh.ok() ? std::move(mesh).value() : nullptr;
#if defined(__cpp_exceptions)
    } catch (const std::exception&) {  // an allocation that Draco should not have tried
        return nullptr;
    }
#endif
}

/// Whether two faces share all their edges: finer levels would have two edges between the same vertices.
bool has_faces_on_each_other(const BaseMesh& base) {
    const auto across = [&](std::uint32_t f, unsigned side) {
        const auto& [first, second] = base.edges()[base.edge_of(f, side)].face;
        return first == f ? second : first;
    };
    for (std::uint32_t f = 0; f < base.face_count(); ++f)
        if (across(f, 0) != kNone && across(f, 0) == across(f, 1)) return true;
    return false;
}

/// Answers code_creases() and code_materials() from bytes.
class LabelReader : DecodedBits, public ModelCoder<DecodedBits> {
 public:
    explicit LabelReader(ByteSpan bytes)
        : DecodedBits(bytes), ModelCoder<DecodedBits>(static_cast<DecodedBits&>(*this)) {}
    using ModelCoder<DecodedBits>::code;
};

Result<PartParams> read_params(ByteReader& in, const PartInfo& info, std::uint8_t transform, std::uint8_t& flags) {
    PartParams p;
    flags = in.u8();
    p.error_code = in.u8();
    p.lattice = read_lattice(in);
    if (in.ok() && info.progressive && (flags & (kBaseCreases | kBaseLossless | kBaseTransform)) != 0)
        return malformed(kCannotSplit);
    if (in.ok() && (flags & kBaseSequential) != 0 && (flags & kBaseGrown) != 0)
        return malformed("the base's mesh is coded in two ways");
    if (in.ok() && (p.lattice.bits < 1 || p.lattice.bits > 30))
        return malformed("the base's precision is out of range");
    if (transform >= kTransformCount) return Error{Errc::Unsupported, 0, "the transform is unknown"};
    p.transform.kind = TransformKind{transform};
    if (info.has_planes()) {
        p.reconstruction = in.u8();
        for (unsigned level = 0; level <= info.levels; ++level) p.steps.push_back(in.u8());
        for (unsigned level = 0; level <= info.levels; ++level) p.across.push_back(in.u8());
    }
    if (flags & kBaseTransform) {
        p.transform.s = static_cast<double>(in.f32());
        const unsigned bits = in.u8();
        if (in.ok() && (!(p.transform.s > 0 && p.transform.s <= 1.1613) || bits > 7))
            return malformed("the transform's parameters are out of range");
        p.transform.table1_weights = (bits & 1) != 0;
        p.transform.loop_template = bits & 2 ? 4 : 10;
        p.transform.local_frames = (bits & 4) == 0;
    }
    p.fast = (flags & kBaseFast) != 0;
    p.lossless = (flags & kBaseLossless) != 0;
    if (p.lossless && (p.lattice.bits > kMaxLosslessBits || !p.lattice.is_plain()))
        return malformed("the base's precision is out of range");
    if (!in.ok()) return malformed("the base is cut");
    return p;
}

ByteSpan read_section(ByteReader& in) {
    return in.bytes(static_cast<std::size_t>(std::min<std::uint64_t>(in.varint(), in.remaining() + 1)));
}

/// Colours of materials; none where they are out of order or more than their bytes.
std::vector<MaterialColor> read_colors(ByteReader& in) {
    constexpr std::uint64_t kBytesOfColor = 5;
    const std::uint64_t count = in.varint();
    if (count == 0 || count > in.remaining() / kBytesOfColor) return {};
    std::vector<MaterialColor> colors;
    std::uint64_t label = 0;
    for (std::uint64_t k = 0; k < count; ++k) {
        const std::uint64_t rise = in.varint();
        if ((k > 0 && rise == 0) || rise > kNone - label) return {};
        label += rise;
        const std::uint8_t r = in.u8(), g = in.u8(), b = in.u8(), a = in.u8();
        colors.push_back({static_cast<std::uint32_t>(label), {r, g, b, a}});
    }
    return colors;
}

}  // namespace

Result<GridMesh> read_draco(ByteSpan bytes, bool sequential, std::uint32_t vertices, std::uint32_t faces) {
    if (const Result<void> r = check_draco_counts(bytes, sequential, vertices, faces); !r.ok()) return r.error();
    const std::unique_ptr<draco::Mesh> mesh = run_draco(bytes, sequential);
    if (!mesh) return malformed("Draco refuses the base");
    const draco::PointAttribute* positions = mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
    if (!positions || positions->num_components() != 3 || positions->data_type() != draco::DT_INT32)
        return malformed("the base has no integer positions");
    GridMesh out;
    out.faces.resize(mesh->num_faces());
    out.grid.resize(mesh->num_points());
    for (std::uint32_t f = 0; f < out.faces.size(); ++f) {
        const draco::Mesh::Face& face = mesh->face(draco::FaceIndex(f));
        for (std::size_t k = 0; k < 3; ++k) out.faces[f][k] = face[k].value();
    }
    for (std::uint32_t v = 0; v < out.grid.size(); ++v)
        if (!positions->ConvertValue<std::int32_t, 3>(positions->mapped_index(draco::PointIndex(v)),
                                                      out.grid[v].data()))
            return malformed("the base has a vertex without a position");
    return out;
}

namespace {

Result<GridMesh> read_level_0(ByteSpan bytes, unsigned flags, unsigned bits, const PartInfo& info) {
    if ((flags & kBaseGrown) == 0)
        return read_draco(bytes, (flags & kBaseSequential) != 0, info.base_vertices, info.base_faces);
    if (info.base_faces > kMaxFacesPerByte * bytes.size())
        return malformed("the base has more faces than its bytes can hold");
    const bool has_boundary = 2 * std::uint64_t{info.base_edges} != 3 * std::uint64_t{info.base_faces};
    return decode_mesh(bytes, info.base_vertices, info.base_faces, has_boundary, bits);
}

/// What a progressive part begins with: its topology is that of what it leads to.
Result<PartInfo> read_coarse_counts(ByteReader& in, const PartInfo& fine) {
    PartInfo coarse = fine;
    const std::uint64_t vertices = in.varint(), faces = in.varint();
    const std::int64_t euler = std::int64_t{fine.base_vertices} - fine.base_edges + fine.base_faces;
    const std::int64_t edges = static_cast<std::int64_t>(vertices + faces) - euler;
    if (!in.ok() || vertices < 3 || vertices > fine.base_vertices || faces < 1 || faces > fine.base_faces ||
        edges < 3 || 3 * faces > 2 * static_cast<std::uint64_t>(edges))
        return malformed("the base's counts do not fit the header's");
    coarse.base_vertices = static_cast<std::uint32_t>(vertices);
    coarse.base_faces = static_cast<std::uint32_t>(faces);
    coarse.base_edges = static_cast<std::uint32_t>(edges);
    return coarse;
}

}  // namespace

Result<DecodedBase> read_base(ByteSpan payload, const PartInfo& part, std::uint8_t transform) {
    ByteReader in(payload);
    DecodedBase base;
    std::uint8_t flags = 0;
    Result<PartParams> params = read_params(in, part, transform, flags);
    if (!params.ok()) return params.error();
    base.params = *params;
    const Result<PartInfo> counts = part.progressive ? read_coarse_counts(in, part) : part;
    if (!counts.ok()) return counts.error();
    const PartInfo& info = *counts;
    const ByteSpan mesh_bytes = read_section(in);
    const ByteSpan creases = flags & kBaseCreases ? read_section(in) : ByteSpan{};
    const ByteSpan materials = flags & kBaseMaterials ? read_section(in) : ByteSpan{};
    if (flags & kBaseColors) base.params.colors = read_colors(in);
    if (!in.ok()) return malformed("the base is cut");
    if ((flags & kBaseColors) != 0 && base.params.colors.empty())
        return malformed("the colours of materials are out of order");

    Result<GridMesh> mesh = read_level_0(mesh_bytes, flags, base.params.lattice.bits, info);
    if (!mesh.ok()) return mesh.error();
    Result<BaseMesh> topology = BaseMesh::create(static_cast<std::uint32_t>(mesh->grid.size()), std::move(mesh->faces));
    if (!topology.ok()) return topology.error();
    base.mesh = std::move(*topology);
    base.grid = std::move(mesh->grid);
    if (base.mesh.vertex_count() != info.base_vertices || base.mesh.edge_count() != info.base_edges ||
        base.mesh.face_count() != info.base_faces)
        return malformed("the base's counts are not the header's");
    if (info.levels > 1 && has_faces_on_each_other(base.mesh))
        return malformed("two faces of the base lie on each other");
    if (flags & kBaseCreases) {
        base.creases.resize(base.mesh.edge_count());
        LabelReader reader(creases);
        code_creases(base.mesh, base.creases, reader);
    }
    if (flags & kBaseMaterials) {
        base.materials.resize(base.mesh.face_count());
        LabelReader reader(materials);
        code_materials(base.mesh, base.materials, reader);
    }
    return base;
}

}  // namespace mvw
