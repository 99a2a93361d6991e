#include "codec/enc_remeshed.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "codec/container/enc_file.h"
#include "codec/enc_errors.h"
#include "codec/enc_original.h"
#include "codec/measure/surface_error.h"

namespace mvw {

namespace {

constexpr std::uint32_t kSamplesForRemeshing = 40'000;
constexpr double kRoundingShare = 0.4;      // of the remeshing error may be added by rounding
constexpr double kFinestRounding = 4e-6;    // where remeshing leaves nothing
constexpr double kFinestAlone = 2e-5;       // of parts that Draco codes alone
constexpr double kVerticesOfTile = 32'768;  // a tile has at least so many, so that its chunks are worth their heads
constexpr unsigned kMostTiles = 64;
constexpr std::uint64_t kLeastOfTile = 8192;  // coarser levels, where tiles would have fewer vertices, are not tiled
constexpr std::size_t kLongestLeastBytes = 8192;
constexpr double kMostOverhead = 0.045;  // of the file: heads, header, index

double area(const Mesh& mesh) {
    double sum = 0;
    for (const Face& f : mesh.faces)
        sum += length(cross(mesh.positions[f[1]] - mesh.positions[f[0]], mesh.positions[f[2]] - mesh.positions[f[0]]));
    return sum / 2;
}

Mesh finest_mesh(const std::vector<SemiRegularMesh>& parts) {
    Mesh out;
    for (const SemiRegularMesh& part : parts) {
        const auto first = static_cast<std::uint32_t>(out.positions.size());
        out.positions.insert(out.positions.end(), part.positions.begin(), part.positions.end());
        for (const Face& f : triangles_at_level(part.base, part.levels))
            out.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    }
    return out;
}

Result<void> box_of(const Mesh& input, FileHeader& header) {
    const Box box = bounding_box(input);
    const Vec3 c = box.center();
    return set_box(header, {c.x, c.y, c.z}, box.diagonal());
}

PartPrecision precision_of(const SemiRegularMesh& part, const EncodeOptions& options, double remesh_error) {
    PartPrecision precision;
    precision.fast = options.profile == Profile::Fast;
    // What remeshing leaves of the wanted error, else a share of what it left.
    const double t = options.target_error, r = remesh_error;
    precision.error = std::max(t > r * 1.1 ? 0.9 * std::sqrt(t * t - r * r) : r * kRoundingShare, kFinestRounding);
    if (part.levels == 0) {
        // A step s of the grid leaves s / sqrt(12) along the normal. Finer than 14 bits only where it was asked for.
        const double error = t > 0 ? precision.error : std::max(precision.error, kFinestAlone);
        precision.base_bits = static_cast<unsigned>(std::clamp(std::ceil(-std::log2(error * 3.4)), 10.0, 20.0));
        return precision;
    }
    const double wanted_tiles =
        options.tile_count > 0
            ? options.tile_count
            : std::min<double>(std::round(double(part.positions.size()) / kVerticesOfTile), kMostTiles);
    precision.tiles =
        static_cast<unsigned>(std::clamp(wanted_tiles, 1.0, double(std::min(part.base.face_count(), 65'535u))));
    const auto vertices_of_tile = [&](unsigned level) { return vertices_at_level(part.base, level) / precision.tiles; };
    precision.first_tiled_level = 1;
    while (precision.first_tiled_level < part.levels && vertices_of_tile(precision.first_tiled_level) < kLeastOfTile)
        ++precision.first_tiled_level;
    return precision;
}

PartInfo info_of(const CodedPart& part, unsigned tiles) {
    return {static_cast<std::uint8_t>(part.mesh.levels),
            part.mesh.base.vertex_count(),
            part.mesh.base.edge_count(),
            part.mesh.base.face_count(),
            static_cast<std::uint16_t>(tiles),
            static_cast<std::uint8_t>(part.first_tiled_level)};
}

unsigned layers_of(const std::vector<CodedPart>& parts) {
    unsigned layers = 1;
    for (const CodedPart& part : parts)
        for (const CodedBlock& block : part.blocks)
            if (!block.planes.planes.empty()) layers = std::max(layers, block.planes.planes.front().plane + 1);
    return layers;
}

std::vector<ChunkToWrite> to_write(const std::vector<PlannedChunk>& plan) {
    std::vector<ChunkToWrite> out;
    for (const PlannedChunk& c : plan) out.push_back({c.id, c.payload, static_cast<float>(c.error)});
    return out;
}

/// Everything about the parts that the chunks' order needs.
struct CodedModel {
    FileHeader header;
    std::vector<CodedPart> parts;
    OrderOptions order;
};

double remeshing_error(const Mesh& input, const std::vector<SemiRegularMesh>& parts, const EncodeOptions& options) {
    return surface_error(input, finest_mesh(parts), {kSamplesForRemeshing, options.threads}).rms;
}

/// A file keeps s as a float: the encoder has to transform with that one.
TransformOptions as_stored(TransformOptions transform) {
    if (transform.s != TransformOptions{}.s) transform.s = static_cast<double>(static_cast<float>(transform.s));
    return transform;
}

void code_parts(const Mesh& input, std::vector<SemiRegularMesh>& meshes, const EncodeOptions& options,
                CodedModel& model) {
    const double remesh_error = remeshing_error(input, meshes, options);
    const std::array<double, 3>& c = model.header.center;
    const unsigned threads = options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    double whole = 0;
    for (SemiRegularMesh& mesh : meshes) {
        model.order.area_share.push_back(area(finest_mesh({mesh})));
        whole += model.order.area_share.back();
        const PartPrecision precision = precision_of(mesh, options, remesh_error);
        for (Vec3& p : mesh.positions) p = (p - Vec3{c[0], c[1], c[2]}) / model.header.diagonal;
        model.parts.push_back(code_part(mesh, as_stored(options.transform), precision, threads));
        model.header.parts.push_back(info_of(model.parts.back(), precision.tiles));
        if (options.progress) options.progress("code", double(model.parts.size()) / double(meshes.size()));
    }
    for (double& share : model.order.area_share) share = whole > 0 ? share / whole : 1;
    model.order.floor = remesh_error * remesh_error;
    model.order.layers = layers_of(model.parts);
    model.header.transform = static_cast<std::uint8_t>(options.transform.kind);
    model.header.layers = static_cast<std::uint8_t>(model.order.layers);
}

/// Fewer, longer chunks until what is not payload is a small share of the file.
Result<Bytes> plan_file(CodedModel& model, std::vector<PlannedChunk>& plan) {
    for (;; model.order.least_bytes = model.order.least_bytes * 3 / 2) {
        plan = order_chunks(model.parts, model.order);
        Result<Bytes> file = write_file(model.header, to_write(plan));
        if (!file.ok()) return file;
        double payload = 0;
        for (const PlannedChunk& c : plan) payload += double(c.payload.size());
        const auto size = double(file->size());
        if (size - payload < kMostOverhead * size || model.order.least_bytes > kLongestLeastBytes) return file;
    }
}

Result<void> add_original(const Mesh& input, const FileHeader& header, const EncodeOptions& options,
                          std::vector<PlannedChunk>& plan) {
    if (options.keep_original == 0) return {};
    PlannedChunk chunk;
    chunk.id.channel = Channel::Original;
    chunk.payload = write_original(input, header, options.keep_original);
    chunk.error = plan.back().error;
    if (chunk.payload.empty()) return Error{Errc::InvalidArgument, 0, "Draco cannot code the original mesh"};
    plan.push_back(std::move(chunk));
    return {};
}

void report(const CodedModel& model, const std::vector<PlannedChunk>& plan, Encoded& out) {
    double in_wavelets = 0;
    for (const CodedPart& part : model.parts) {
        const auto vertices = double(part.mesh.positions.size());
        out.vertices += part.mesh.positions.size();
        out.base_faces += part.mesh.base.face_count();
        out.levels = std::max(out.levels, part.mesh.levels);
        out.tangential_share += part.tangential_share * vertices;
        if (part.mesh.levels > 0) in_wavelets += vertices;
    }
    if (in_wavelets > 0) out.tangential_share /= in_wavelets;
    for (const PlannedChunk& c : plan) {
        if (c.id.channel == Channel::Base) out.base_bytes += c.payload.size();
        if (c.id.channel == Channel::Color) out.color_bytes += c.payload.size();
        if (c.id.channel == Channel::Original) out.original_bytes += c.payload.size();
    }
    out.parts = static_cast<std::uint32_t>(model.parts.size());
    out.transform = TransformKind{model.header.transform};
}

}  // namespace

Result<void> encode_remeshed(const Mesh& input, RemeshResult remeshed, const EncodeOptions& options, Encoded& out) {
    CodedModel model;
    if (const Result<void> r = box_of(input, model.header); !r.ok()) return r;
    code_parts(input, remeshed.parts, options, model);
    std::vector<PlannedChunk> plan;
    const Result<Bytes> estimated = plan_file(model, plan);
    if (!estimated.ok()) return estimated.error();
    const SurfaceError error = measure_errors(input, *estimated, plan, options);
    if (const Result<void> r = add_original(input, model.header, options, plan); !r.ok()) return r;
    Result<Bytes> file = write_file(model.header, to_write(plan));
    if (!file.ok()) return file.error();
    out.file = std::move(*file);
    out.draco_area_share = remeshed.alone_area_share;
    out.rms = error.rms;
    out.max = error.max;
    out.psnr = error.psnr;
    report(model, plan, out);
    return {};
}

}  // namespace mvw
