#include "codec/enc_stage.h"

#include <algorithm>
#include <cmath>

#include "codec/enc_lattice.h"
#include "codec/remesh/simplify.h"
#include "codec/tiles.h"

namespace mvw {

namespace {

constexpr std::uint32_t kVerticesOfTile = 60, kMostTiles = 16;  // so that one tile more is a small step, too
constexpr std::uint32_t kSamples = 30'000, kSamplesOfVersions = 10'000;
constexpr double kFewerFaces = 0.85;  // of one version for the next
constexpr std::size_t kFewestFaces = 32;

/// from: in coded units. No creases: flags of these cost more than finer steps at their ends save.
std::optional<SemiRegularMesh> part_of(const Mesh& from) {
    SemiRegularMesh mesh;
    Result<BaseMesh> base = BaseMesh::create(static_cast<std::uint32_t>(from.positions.size()), from.faces);
    if (!base.ok()) return std::nullopt;
    mesh.base = std::move(*base);
    mesh.materials = from.materials;
    mesh.positions = from.positions;
    return mesh;
}

Mesh in_coded_units(const EncoderInput& input) {
    Mesh mesh;
    mesh.faces = input.mesh().faces;
    mesh.materials = input.mesh().materials;
    for (const Vec3& p : input.mesh().positions) mesh.positions.push_back(input.to_coded_units(p));
    return mesh;
}

/// RMS error of a version with rounded vertices.
double error_of(const EncoderInput& input, const Lod& lod, const Rounded& base, unsigned threads) {
    const std::optional<SurfaceError> error =
        error_of(input, lod.mesh.base.faces(), points_of(base), sampled(kSamples, threads));
    return error ? error->rms : 1;
}

/// Weighs what a tile's planes gain by the surface that its vertices stand for: a few long triangles may be half of it.
void weigh_by_area(CodedPart& part, unsigned tiles) {
    const BaseMesh& base = part.mesh.base;
    const std::vector<Vec3>& at = part.mesh.positions;
    const Tiling tiling(base, tile_of_faces(base, tiles), tiles);
    std::vector<double> area(tiles, 0);  // of a third of each face at each vertex
    double whole = 0;
    for (const Face& f : base.faces()) {
        const double third = length(cross(at[f[1]] - at[f[0]], at[f[2]] - at[f[0]])) / 6;
        for (const std::uint32_t v : f) area[tiling.vertex[v].tile] += third;
        whole += 3 * third;
    }
    if (whole <= 0) return;
    for (CodedBlock& block : part.blocks) {
        const auto vertices = static_cast<double>(tiling.tiles[block.tile].vertices.size());
        for (double& gain : block.gain) gain *= area[block.tile] / whole * base.vertex_count() / vertices;
    }
}

}  // namespace

std::optional<Lod> own_version(const EncoderInput& input) {
    std::optional<SemiRegularMesh> part = part_of(in_coded_units(input));
    if (!part) return std::nullopt;
    return Lod{std::move(*part), 0};
}

std::vector<Lod> versions_of(const EncoderInput& input, Lod own, const std::vector<VersionLimit>& limits,
                             unsigned threads) {
    std::vector<Lod> versions;
    Lod last = std::move(own);
    const Mesh from = in_coded_units(input);
    Simplifier simplifier(from);
    while (versions.size() < limits.size()) {
        const std::size_t before = simplifier.faces();
        simplifier.simplify(static_cast<std::size_t>(double(before) * kFewerFaces));
        const Mesh mesh = simplifier.mesh();
        std::optional<SemiRegularMesh> part;
        if (simplifier.faces() < before && mesh.faces.size() >= kFewestFaces) part = part_of(mesh);
        SurfaceErrorOptions sampling = sampled(kSamplesOfVersions, threads);
        const auto is_within = [&](const std::optional<SurfaceError>& error) {
            const VersionLimit& limit = limits[versions.size()];
            return error && error->rms <= limit.rms && error->max <= limit.max;
        };
        std::optional<SurfaceError> error;
        if (part) error = error_of(input, mesh.faces, mesh.positions, sampling);
        if (error && std::isfinite(limits[versions.size()].max)) {  // then spikes matter
            sampling.vertex_stride = 1;
            error->max = error_of(input, mesh.faces, mesh.positions, sampling)->max;
        }
        while (versions.size() < limits.size() && !is_within(error)) versions.push_back(last);
        if (error) last = {std::move(*part), error->rms};
    }
    return versions;
}

std::optional<SurfaceError> error_of(const EncoderInput& input, const std::vector<Face>& faces,
                                     std::span<const Vec3> positions, const SurfaceErrorOptions& sampling) {
    Mesh mesh;
    mesh.faces = faces;
    for (const Vec3& p : positions) mesh.positions.push_back(input.to_model_units(p));
    if (!measurable(mesh)) return std::nullopt;
    return input.reference().error_of(mesh, sampling);
}

double error_on_grid(const EncoderInput& input, const Lod& lod, unsigned bits, unsigned threads) {
    return error_of(input, lod, round_to_lattice(lod.mesh.positions, lod.mesh.base.faces(), bits), threads);
}

namespace {

PartPrecision precision_of(const EncoderInput& input, const BaseMesh& base, const StageOptions& options) {
    PartPrecision precision;
    precision.colors = input.mesh().material_colors;
    precision.base_bits = options.bits;
    precision.supersedes = options.error > 0;
    precision.fast = options.fast;
    precision.error = options.error;
    if (precision.supersedes)
        precision.tiles =
            std::clamp(base.vertex_count() / kVerticesOfTile, 1u, std::min(kMostTiles, base.face_count()));
    return precision;
}

/// error, first: of the version, and on its lattice.
Stage make_stage(CodedPart part, const PartPrecision& precision, double error, double first) {
    const BaseMesh& base = part.mesh.base;
    Stage stage;
    stage.info.base_vertices = base.vertex_count();
    stage.info.base_edges = base.edge_count();
    stage.info.base_faces = base.face_count();
    stage.info.tiles = static_cast<std::uint16_t>(precision.tiles);
    stage.info.supersedes = precision.supersedes;
    std::vector<CodedPart> parts;
    parts.push_back(std::move(part));
    weigh_by_area(parts[0], precision.tiles);
    stage.layers = layers_of(parts);
    OrderOptions order;
    order.layers = stage.layers;
    order.area_share = {1};
    order.least_bytes = 1;  // each plane of a tile by itself: together they would be a large step
    stage.chunks = order_chunks(parts, order);
    for (PlannedChunk& c : stage.chunks) c.error = std::min(std::sqrt(c.error + error * error), first);
    stage.chunks.front().error = first;
    stage.part = std::move(parts[0]);
    return stage;
}

}  // namespace

Stage code_stage(const EncoderInput& input, const Lod& lod, const StageOptions& options) {
    const PartPrecision precision = precision_of(input, lod.mesh.base, options);
    const Rounded rounded = round_to_lattice(lod.mesh.positions, lod.mesh.base.faces(), options.bits);
    return make_stage(code_part(lod.mesh, TransformOptions{}, precision, rounded, options.threads), precision,
                      lod.error, error_of(input, lod, rounded, options.threads));
}

Stage code_planes_of(const EncoderInput& input, const Lod& lod, const Rounded& rounded, const StageOptions& options) {
    const PartPrecision precision = precision_of(input, lod.mesh.base, options);
    return make_stage(code_planes(lod.mesh, precision, rounded, options.threads), precision, lod.error,
                      error_of(input, lod, rounded, options.threads));
}

}  // namespace mvw
