#include "codec/enc_errors.h"

#include <algorithm>
#include <cmath>

#include "codec/container/crc32c.h"
#include "codec/mesh/semi_regular.h"
#include "codec/part_params.h"

namespace mvw {

std::uint64_t vertices_of(const FileHeader& header) {
    std::uint64_t vertices = 0;
    for (const PartInfo& p : header.parts)
        vertices += vertices_at_level(p.base_vertices, p.base_edges, p.base_faces, p.levels);
    return vertices;
}

PlanDecoder::PlanDecoder(ByteSpan file) {
    (void)decoder_.feed_header(file).ok();
}

void PlanDecoder::feed(const PlannedChunk& chunk) {
    (void)decoder_.feed_chunk(chunk.id, chunk.payload, crc32c(chunk.payload)).ok();
}

void PlanDecoder::feed(std::span<const PlannedChunk> chunks) {
    for (const PlannedChunk& c : chunks) feed(c);
}

std::optional<SurfaceError> PlanDecoder::error(const EncoderInput& input, const SurfaceErrorOptions& sampling) const {
    const Result<Mesh> mesh = decoder_.mesh();
    if (!mesh.ok() || !measurable(*mesh)) return std::nullopt;
    return input.reference().error_of(*mesh, sampling);
}

namespace {

constexpr std::uint32_t kSamplesOnTheWay = 10'000;
constexpr std::uint32_t kSamplesAtTheEnd = 300'000;
constexpr std::size_t kFewChunks = 48;            // measured at each
constexpr std::uint64_t kManyVertices = 150'000;  // measured at fewer points

struct Point {
    std::size_t chunk;
    double estimated, measured;
};

/// Decodes as a client would and measures: at first, wherever the estimate or the bytes have changed enough since the
/// last time, and at the end.
std::vector<Point> measure(const EncoderInput& input, const std::vector<PlannedChunk>& plan, ByteSpan file,
                           SurfaceError& last, const EncodeOptions& options) {
    std::vector<Point> points;
    PlanDecoder decoder(file);
    const double ratio = vertices_of(decoder.header()) < kManyVertices ? 1.2 : 1.8;  // of bytes; squared, of estimates
    double error = 0, bytes = 0, bytes_then = 0;
    const auto part = [&](std::size_t k) -> const PartInfo& { return decoder.header().parts[plan[k].id.part]; };
    const auto closes = [&](std::size_t k) { return part(k).supersedes; };
    std::size_t previews = 0;  // chunks
    while (previews < plan.size() && part(previews).preview) ++previews;
    std::size_t bases = previews;  // where the last of those ends without which nothing but a preview is shown
    while (bases < plan.size() && plan[bases].id.channel == Channel::Base && !closes(bases)) ++bases;
    for (std::size_t i = 0; i < plan.size(); ++i) {
        decoder.feed(plan[i]);
        bytes += double(plan[i].payload.size());
        const bool end = i + 1 == plan.size();
        const auto is_seam = [&](std::size_t a, std::size_t b) {
            return plan[a].id.part != plan[b].id.part && (closes(a) || closes(b));
        };
        const bool seam = (!end && is_seam(i, i + 1)) || (i > 0 && is_seam(i, i - 1));
        // Estimates of a closing part's planes are rougher than those of details: they know of vertices only.
        const bool splits = plan[i].id.channel == Channel::Splits;
        const bool plain = closes(i) || part(i).progressive;
        const bool rough = splits || (plain && i % 2 == 0);
        const bool changed = seam || rough || plan.size() < kFewChunks || i + 1 == bases || i + 1 == previews ||
                             plan[i].error < error / (ratio * ratio) || bytes > ratio * bytes_then;
        if ((i >= previews && i + 1 < bases) || (!end && !changed)) continue;
        // The same mixture of samples and vertices, so that the figures agree.
        const SurfaceErrorOptions sampling{end ? kSamplesAtTheEnd : kSamplesOnTheWay, options.threads,
                                           end ? 1 : kSamplesAtTheEnd / kSamplesOnTheWay};
        const std::optional<SurfaceError> e = decoder.error(input, sampling);
        if (!e) continue;
        error = plan[i].error;
        bytes_then = bytes;
        points.push_back({i, std::sqrt(plan[i].error), e->rms});
        if (end) last = *e;
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

SurfaceError measure_errors(const EncoderInput& input, ByteSpan file, std::vector<PlannedChunk>& plan,
                            const EncodeOptions& options) {
    SurfaceError error;
    calibrate(plan, measure(input, plan, file, error, options));
    return error;
}

}  // namespace mvw
