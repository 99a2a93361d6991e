#include "codec/enc_base.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <memory>
#include <unordered_map>

#include "codec/entropy/enc_bits.h"
#include "codec/entropy/enc_mesh.h"
#include "codec/entropy/model_coder.h"
#include "codec/labels.h"
#include "codec/mesh/vertex_data.h"

namespace mvw {

namespace {

std::unique_ptr<draco::Mesh> draco_mesh(const std::vector<Face>& faces, const std::vector<GridPoint>& grid) {
    auto mesh = std::make_unique<draco::Mesh>();
    mesh->SetNumFaces(faces.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        draco::Mesh::Face face;
        for (std::size_t k = 0; k < 3; ++k) face[k] = draco::PointIndex(faces[f][k]);
        mesh->SetFace(draco::FaceIndex(f), face);
    }
    mesh->set_num_points(static_cast<std::uint32_t>(grid.size()));
    draco::GeometryAttribute attribute;
    attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_INT32, false, 3 * sizeof(std::int32_t), 0);
    const int id = mesh->AddAttribute(attribute, true, static_cast<std::uint32_t>(grid.size()));
    for (std::uint32_t v = 0; v < grid.size(); ++v)
        mesh->attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), grid[v].data());
    return mesh;
}

/// Draco's bytes without the 11 in front; empty where it refuses.
Bytes run_draco(const draco::Mesh& mesh, bool sequential, int speed) {
    draco::ExpertEncoder encoder(mesh);
    encoder.SetEncodingMethod(sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(speed, speed);
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeToBuffer(&buffer).ok() || buffer.size() < 11) return {};
    const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
    return {bytes + 11, bytes + buffer.size()};
}

/// Finds, for each decoded face, its source: a walk over both meshes in step from pairs of faces with equal corners.
/// Any walk that meets equal positions and equal neighbours everywhere is right, even where points coincide.
class Matcher {
 public:
    Matcher(const BaseMesh& source, const std::vector<GridPoint>& source_grid, CodedBase& coded)
        : source_(source), source_grid_(source_grid), coded_(coded) {}

    bool run() {
        const std::uint32_t F = source_.face_count();
        coded_.source_face.assign(F, kNone);
        coded_.source_corner.assign(F, 0);
        taken_.assign(F, 0);
        std::unordered_multimap<std::uint64_t, std::uint32_t> by_corners;
        for (std::uint32_t f = 0; f < F; ++f) by_corners.emplace(key(source_, source_grid_, f), f);
        for (std::uint32_t f = 0; f < F; ++f) {
            if (coded_.source_face[f] != kNone) continue;
            const auto [first, last] = by_corners.equal_range(key(coded_.mesh, coded_.grid, f));
            bool found = false;
            for (auto it = first; it != last && !found; ++it)
                for (unsigned corner = 0; corner < 3 && !found; ++corner) found = walk_from(f, it->second, corner);
            if (!found) return false;
        }
        return true;
    }

 private:
    /// Equal for faces with the same three positions, however turned.
    static std::uint64_t key(const BaseMesh& mesh, const std::vector<GridPoint>& grid, std::uint32_t f) {
        std::uint64_t sum = 0;
        for (const std::uint32_t v : mesh.faces()[f]) {
            std::uint64_t h = 0;
            for (const std::int32_t x : grid[v]) h = (h ^ static_cast<std::uint32_t>(x)) * 0x9E3779B97F4A7C15ull;
            sum += h ^ (h >> 29);
        }
        return sum;
    }
    [[nodiscard]] bool same_corners(std::uint32_t f, std::uint32_t g, unsigned corner) const {
        for (unsigned k = 0; k < 3; ++k)
            if (coded_.grid[coded_.mesh.faces()[f][k]] != source_grid_[source_.faces()[g][(k + corner) % 3]])
                return false;
        return true;
    }
    /// Pairs f with g and everything connected to them; undoes all of it where they do not fit.
    bool walk_from(std::uint32_t f, std::uint32_t g, unsigned corner) {
        std::vector<std::uint32_t> done;
        const bool fits = pair(f, g, corner, done) && walk(done);
        if (!fits)
            for (const std::uint32_t d : done) taken_[coded_.source_face[d]] = 0, coded_.source_face[d] = kNone;
        return fits;
    }
    bool pair(std::uint32_t f, std::uint32_t g, unsigned corner, std::vector<std::uint32_t>& done) {
        if (coded_.source_face[f] != kNone) return coded_.source_face[f] == g && coded_.source_corner[f] == corner;
        if (taken_[g] || !same_corners(f, g, corner)) return false;
        coded_.source_face[f] = g;
        coded_.source_corner[f] = static_cast<std::uint8_t>(corner);
        taken_[g] = 1;
        done.push_back(f);
        return true;
    }
    bool walk(std::vector<std::uint32_t>& done) {
        for (std::size_t i = 0; i < done.size(); ++i) {
            const std::uint32_t f = done[i], g = coded_.source_face[f];
            for (unsigned s = 0; s < 3; ++s) {
                const BaseMesh::Side next = coded_.mesh.beyond(f, s);
                const BaseMesh::Side source_next = source_.beyond(g, (s + coded_.source_corner[f]) % 3);
                if ((next.face == kNone) != (source_next.face == kNone)) return false;
                if (next.face != kNone &&
                    !pair(next.face, source_next.face, (source_next.side + 3 - next.side) % 3, done))
                    return false;
            }
        }
        return true;
    }

    const BaseMesh& source_;
    const std::vector<GridPoint>& source_grid_;
    CodedBase& coded_;
    std::vector<std::uint8_t> taken_;
};

/// Bytes beyond what is read are allowed: they make room for a mesh so regular that it takes next to none.
void make_room(CodedBase& coded, const BaseMesh& source) {
    coded.bytes.resize(std::max<std::size_t>(coded.bytes.size(), source.face_count() / kMaxFacesPerByte + 1));
}

/// Decodes Draco's own bytes and finds the source of every face; false where the mesh has changed.
bool adopt(CodedBase& coded, const BaseMesh& source, const std::vector<GridPoint>& grid) {
    make_room(coded, source);
    const bool sequential = coded.method == BaseMethod::Sequential;
    Result<GridMesh> mesh = read_draco(coded.bytes, sequential, source.vertex_count(), source.face_count());
    if (!mesh.ok() || mesh->grid.size() != source.vertex_count()) return false;
    Result<BaseMesh> topology = BaseMesh::create(source.vertex_count(), std::move(mesh->faces));
    if (!topology.ok() || topology->face_count() != source.face_count() ||
        topology->edge_count() != source.edge_count())
        return false;
    coded.mesh = std::move(*topology);
    coded.grid = std::move(mesh->grid);
    return Matcher(source, grid, coded).run();
}

class LabelWriter : EncodedBits, public ModelCoder<EncodedBits> {
 public:
    LabelWriter() : ModelCoder<EncodedBits>(static_cast<EncodedBits&>(*this)) {}
    using ModelCoder<EncodedBits>::code, EncodedBits::take_bytes;
};

void write_section(ByteWriter& out, ByteSpan bytes) {
    out.varint(bytes.size());
    out.bytes(bytes);
}

}  // namespace

Bytes write_draco(const std::vector<Face>& faces, const std::vector<GridPoint>& grid, bool sequential, int speed) {
    return run_draco(*draco_mesh(faces, grid), sequential, speed);
}

namespace {

/// False where the growing coder cannot.
bool grow_base(const BaseMesh& source, const std::vector<GridPoint>& grid, unsigned bits, CodedBase& coded) {
    const std::int64_t most = std::int64_t{1} << bits;
    const auto fits = [&](const GridPoint& p) {
        return std::all_of(p.begin(), p.end(), [&](std::int64_t x) { return x >= -most && x <= most; });
    };
    if (bits > kMaxMeshBits || !std::all_of(grid.begin(), grid.end(), fits)) return false;
    EncodedMesh encoded = encode_mesh(source, grid, bits);
    if (encoded.bytes.empty()) return false;
    const MeshOrigin& from = encoded.origin;
    std::vector<Face> faces(source.face_count());
    std::vector<std::uint32_t> number(source.vertex_count());
    for (std::uint32_t v = 0; v < number.size(); ++v) {
        number[from.vertex[v]] = v;
        coded.grid.push_back(grid[from.vertex[v]]);
    }
    for (std::uint32_t f = 0; f < faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k)
            faces[f][k] = number[source.faces()[from.face[f]][(k + from.corner[f]) % 3]];
    coded.mesh = BaseMesh::create(source.vertex_count(), std::move(faces)).value();
    coded.source_face = from.face;
    coded.source_corner = from.corner;
    coded.bytes = std::move(encoded.bytes);
    make_room(coded, source);
    return true;
}

/// Draco's shortest bytes that keep the mesh.
CodedBase draco_base(const BaseMesh& source, const std::vector<GridPoint>& grid) {
    const std::unique_ptr<draco::Mesh> mesh = draco_mesh(source.faces(), grid);
    CodedBase best;
    for (const int speed : {0, 1, 3, 5, 7}) {
        CodedBase coded;
        coded.method = BaseMethod::Edgebreaker;
        coded.bytes = run_draco(*mesh, false, speed);
        if (coded.bytes.empty() || (!best.bytes.empty() && coded.bytes.size() >= best.bytes.size())) continue;
        if (adopt(coded, source, grid)) best = std::move(coded);
    }
    if (best.bytes.empty()) {
        best.method = BaseMethod::Sequential;
        best.bytes = run_draco(*mesh, true, 0);
        const bool kept = adopt(best, source, grid);
        assert(kept);
        (void)kept;
    }
    return best;
}

}  // namespace

CodedBase code_base(const BaseMesh& source, const std::vector<GridPoint>& grid, unsigned bits, bool alone) {
    CodedBase by_draco = draco_base(source, grid), grown;
    const bool shorter = !alone && grow_base(source, grid, bits, grown) && grown.bytes.size() < by_draco.bytes.size();
    return shorter ? grown : by_draco;
}

SemiRegularMesh renumber(const SemiRegularMesh& source, const CodedBase& base) {
    SemiRegularMesh out;
    out.base = base.mesh;
    out.levels = source.levels;
    std::vector<std::uint32_t> from, to, source_vertex(source.positions.size());
    const std::uint32_t n = 1u << source.levels;
    for (std::uint32_t f = 0; f < base.mesh.face_count(); ++f) {
        patch_vertices(out.base, f, source.levels, to);
        patch_vertices(source.base, base.source_face[f], source.levels, from);
        const unsigned corner = base.source_corner[f];
        std::size_t at = 0;
        for (std::uint32_t i = 0; i <= n; ++i)
            for (std::uint32_t k = 0; i + k <= n; ++k, ++at) {
                // Weights over the corners 0, 1, 2 of f; corner c of f is corner (c + corner) mod 3 of the source.
                const std::array<std::uint32_t, 3> w = {n - i - k, i, k};
                const std::uint32_t si = w[(4 - corner) % 3], sk = w[(5 - corner) % 3];
                const std::size_t row = std::size_t{si} * (n + 1) - std::size_t{si} * (si - (si > 0)) / 2;
                source_vertex[to[at]] = from[row + sk];
            }
    }
    for (const std::uint32_t v : source_vertex) {
        out.positions.push_back(source.positions[v]);
        append_vertex_data(source, v, out);
    }
    if (!source.creases.empty()) {
        out.creases.resize(out.base.edge_count());
        for (std::uint32_t f = 0; f < out.base.face_count(); ++f)
            for (unsigned s = 0; s < 3; ++s)
                out.creases[out.base.edge_of(f, s)] =
                    source.creases[source.base.edge_of(base.source_face[f], (s + base.source_corner[f]) % 3)];
    }
    for (std::uint32_t f = 0; !source.materials.empty() && f < out.base.face_count(); ++f)
        out.materials.push_back(source.materials[base.source_face[f]]);
    return out;
}

namespace {

void write_colors(ByteWriter& out, const std::vector<MaterialColor>& colors) {
    out.varint(colors.size());
    std::uint32_t before = 0;
    for (const auto& [label, color] : colors) {
        out.varint(label - before);
        for (const std::uint8_t byte : {color.r, color.g, color.b, color.a}) out.u8(byte);
        before = label;
    }
}

}  // namespace

Bytes write_base(const CodedBase& base, const SemiRegularMesh& mesh, const PartParams& params) {
    const TransformOptions &t = params.transform, defaults;
    const bool own_transform = t.s != defaults.s || t.table1_weights != defaults.table1_weights ||
                               t.loop_template != defaults.loop_template || t.local_frames != defaults.local_frames;
    const bool creases = std::any_of(mesh.creases.begin(), mesh.creases.end(), [](std::uint8_t c) { return c != 0; });
    ByteWriter out;
    out.u8(static_cast<std::uint8_t>((base.method == BaseMethod::Sequential ? kBaseSequential : 0) |
                                     (base.method == BaseMethod::Grown ? kBaseGrown : 0) |
                                     (creases ? kBaseCreases : 0) | (mesh.materials.empty() ? 0 : kBaseMaterials) |
                                     (own_transform ? kBaseTransform : 0) | (params.fast ? kBaseFast : 0) |
                                     (params.lossless ? kBaseLossless : 0) |
                                     (params.colors.empty() ? 0 : kBaseColors)));
    out.u8(params.error_code);
    write_lattice(out, params.lattice);
    if (!params.steps.empty()) {
        out.u8(params.reconstruction);
        for (const std::uint8_t code : params.steps) out.u8(code);
        for (const std::uint8_t code : params.across) out.u8(code);
    }
    if (own_transform) {
        out.f32(static_cast<float>(t.s));
        out.u8(static_cast<std::uint8_t>((t.table1_weights ? 1 : 0) | (t.loop_template == 4 ? 2 : 0) |
                                         (t.local_frames ? 0 : 4)));
    }
    if (base.progressive) {
        out.varint(base.mesh.vertex_count());
        out.varint(base.mesh.face_count());
    }
    write_section(out, base.bytes);
    if (creases) {
        LabelWriter writer;
        std::vector<std::uint8_t> bits = mesh.creases;
        code_creases(mesh.base, bits, writer);
        write_section(out, writer.take_bytes());
    }
    if (!mesh.materials.empty()) {
        LabelWriter writer;
        std::vector<std::uint32_t> labels = mesh.materials;
        code_materials(mesh.base, labels, writer);
        write_section(out, writer.take_bytes());
    }
    if (!params.colors.empty()) write_colors(out, params.colors);
    return out.take();
}

}  // namespace mvw
