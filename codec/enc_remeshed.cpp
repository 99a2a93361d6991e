#include "codec/enc_remeshed.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "codec/container/crc32c.h"
#include "codec/container/enc_file.h"
#include "codec/decoder.h"
#include "codec/enc_order.h"
#include "codec/measure/surface_error.h"

namespace mvw {

namespace {

constexpr std::uint32_t kSamplesOnTheWay = 40'000;  // of a calibration point
constexpr std::size_t kFewChunks = 48;              // measured at each
constexpr std::uint64_t kManyVertices = 150'000;    // measured at fewer points
constexpr std::uint32_t kSamplesAtTheEnd = 300'000;
constexpr double kRoundingShare = 0.4;      // of the remeshing error may be added by rounding
constexpr double kFinestRounding = 4e-6;    // where remeshing leaves nothing
constexpr double kFinestAlone = 2e-5;       // of parts that Draco codes alone
constexpr double kVerticesOfTile = 32'768;  // a tile has at least so many, so that its chunks are worth their heads
constexpr unsigned kMostTiles = 64;
constexpr std::uint64_t kLeastOfTile = 8192;  // coarser levels, where tiles would have fewer vertices, are not tiled
constexpr double kMostOverhead = 0.045;       // of the file: heads, header, index

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

struct Point {
    std::size_t chunk;
    double estimated, measured;
};

/// Decodes as a client would and measures: at first, wherever the estimate or the bytes have changed enough since the
/// last time, and at the end.
std::vector<Point> measure(const Mesh& input, const std::vector<PlannedChunk>& plan, ByteSpan file,
                           std::uint64_t vertices, SurfaceError& last, const EncodeOptions& options) {
    const double ratio = vertices < kManyVertices ? 1.3 : 1.8;  // of bytes; its square, of mean squared errors
    std::vector<Point> points;
    Decoder decoder;
    (void)decoder.feed_header(file).ok();
    double error = 0, bytes = 0, bytes_then = 0;
    std::size_t bases = 0;
    while (bases < plan.size() && plan[bases].id.channel == Channel::Base) ++bases;
    for (std::size_t i = 0; i < plan.size(); ++i) {
        (void)decoder.feed_chunk(plan[i].id, plan[i].payload, crc32c(plan[i].payload)).ok();
        bytes += double(plan[i].payload.size());
        const bool end = i + 1 == plan.size();
        const bool changed = plan.size() < kFewChunks || i + 1 == bases || plan[i].error < error / (ratio * ratio) ||
                             bytes > ratio * bytes_then;
        if (i + 1 < bases || (!end && !changed)) continue;
        const Result<Mesh> mesh = decoder.mesh();
        if (!mesh.ok() || !measurable(*mesh)) continue;
        error = plan[i].error;
        bytes_then = bytes;
        const SurfaceError e =
            surface_error(input, *mesh, {end ? kSamplesAtTheEnd : kSamplesOnTheWay, options.threads});
        points.push_back({i, std::sqrt(plan[i].error), e.rms});
        if (end) last = e;
        if (options.progress) options.progress("measure", double(i + 1) / double(plan.size()));
    }
    return points;
}

double interpolated(const Point& a, const Point& b, double estimated) {
    if (!(a.estimated > b.estimated) || !(b.estimated > 0) || !(b.measured > 0)) return b.measured;
    const double t = std::log(a.estimated / estimated) / std::log(a.estimated / b.estimated);
    const double ratio = std::log(a.measured / a.estimated) * (1 - t) + std::log(b.measured / b.estimated) * t;
    return estimated * std::exp(ratio);
}

/// Replaces estimated mean squared errors by RMS errors that were measured at some of the chunks: between those, the
/// ratio of measured to estimated follows the logarithm of the estimate.
void calibrate(std::vector<PlannedChunk>& plan, const std::vector<Point>& points) {
    if (points.empty()) return;
    std::size_t next = 0;
    double before = 1;
    for (std::size_t i = 0; i < plan.size(); ++i) {
        while (next + 1 < points.size() && points[next].chunk < i) ++next;
        const double estimated = std::sqrt(plan[i].error);
        const double error = next == 0 || points[next].chunk == i
                                 ? points[next].measured
                                 : interpolated(points[next - 1], points[next], estimated);
        plan[i].error = before = std::min(before, error);
        plan[i].payload[plan[i].id.channel == Channel::Base ? 1 : 0] = std::byte{error_to_code(before)};
    }
}

}  // namespace

Result<void> encode_remeshed(const Mesh& input, RemeshResult remeshed, const EncodeOptions& options, Encoded& out) {
    FileHeader header;
    if (const Result<void> r = box_of(input, header); !r.ok()) return r;
    header.transform = static_cast<std::uint8_t>(options.transform.kind);
    TransformOptions transform = options.transform;
    if (transform.s != TransformOptions{}.s) transform.s = static_cast<double>(static_cast<float>(transform.s));

    const SurfaceErrorOptions quick{kSamplesOnTheWay, options.threads};
    const double remesh_error = surface_error(input, finest_mesh(remeshed.parts), quick).rms;
    const Vec3 center{header.center[0], header.center[1], header.center[2]};
    const unsigned threads = options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    std::vector<CodedPart> parts;
    OrderOptions order;
    double vertices = 0;
    for (SemiRegularMesh& part : remeshed.parts) {
        order.area_share.push_back(area(finest_mesh({part})));
        const PartPrecision precision = precision_of(part, options, remesh_error);
        for (Vec3& p : part.positions) p = (p - center) / header.diagonal;
        parts.push_back(code_part(part, transform, precision, threads));
        header.parts.push_back(info_of(parts.back(), precision.tiles));
        out.vertices += part.positions.size();
        out.base_faces += part.base.face_count();
        out.levels = std::max(out.levels, part.levels);
        out.tangential_share += parts.back().tangential_share * double(part.positions.size());
        vertices += part.levels > 0 ? double(part.positions.size()) : 0;
        if (options.progress) options.progress("code", double(parts.size()) / double(remeshed.parts.size()));
    }
    double whole = 0;
    for (const double a : order.area_share) whole += a;
    for (double& a : order.area_share) a = whole > 0 ? a / whole : 1;
    order.floor = remesh_error * remesh_error;
    order.layers = layers_of(parts);
    header.layers = static_cast<std::uint8_t>(order.layers);

    // Fewer, longer chunks until what is not payload is a small share of the file.
    std::vector<PlannedChunk> plan;
    Result<Bytes> file = Bytes{};
    for (;; order.least_bytes = order.least_bytes * 3 / 2) {
        plan = order_chunks(parts, order);
        file = write_file(header, to_write(plan));
        if (!file.ok()) return file.error();
        double payload = 0;
        for (const PlannedChunk& c : plan) payload += double(c.payload.size());
        if (double(file->size()) - payload < kMostOverhead * double(file->size()) || order.least_bytes > 8192) break;
    }
    SurfaceError error;
    calibrate(plan, measure(input, plan, *file, out.vertices, error, options));
    file = write_file(header, to_write(plan));
    if (!file.ok()) return file.error();

    for (const PlannedChunk& c : plan)
        if (c.id.channel == Channel::Base) out.base_bytes += c.payload.size();
    out.file = std::move(*file);
    out.parts = static_cast<std::uint32_t>(parts.size());
    out.tangential_share = vertices > 0 ? out.tangential_share / vertices : 0;
    out.draco_area_share = remeshed.alone_area_share;
    out.rms = error.rms;
    out.max = error.max;
    out.psnr = error.psnr;
    out.transform = options.transform.kind;
    return {};
}

}  // namespace mvw
