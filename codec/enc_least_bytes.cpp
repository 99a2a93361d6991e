#include "codec/enc_least_bytes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "codec/container/toc.h"
#include "codec/decoder.h"
#include "codec/enc_errors.h"
#include "codec/part_params.h"
#include "codec/remesh/parallel.h"

namespace mvw {

namespace {

constexpr std::uint32_t kSamples = 30'000;
constexpr std::array kShares{0.08, 0.2, 0.35, 0.5, 0.7, 0.85};  // of a chunk's bytes
constexpr double kMargin = 0.05;              // added to such a share: other samples find other spikes
constexpr unsigned kHalvings = 2;             // of what lies between two of these
constexpr double kWorse = 1.0025;             // times the RMS error, 0.02 dB: what samples differ by
constexpr std::size_t kMostWork = 4'000'000;  // vertices and shares measured

bool starts_details(const PlannedChunk& chunk) {
    if (chunk.id.channel != Channel::Geometry || chunk.id.level == 0) return false;
    ByteReader in(chunk.payload);
    const GeometryFront front = read_geometry_front(in);
    return front.starts && !front.beginning;
}

void say(std::size_t least_bytes, PlannedChunk& chunk) {
    ByteReader in(chunk.payload);
    GeometryFront front = read_geometry_front(in);
    front.least_bytes = least_bytes;
    chunk.payload = with_front(front, in);
}

/// RMS error of a file's beginning; infinite where it shows nothing.
double error_of(const EncoderInput& input, ByteSpan beginning) {
    const Result<Mesh> mesh = decode(beginning);
    if (!mesh.ok() || !measurable(*mesh)) return INFINITY;
    return input.reference().error_of(*mesh, sampled(kSamples, 1)).rms;
}

/// The share of a chunk's bytes from which on no beginning is worse than none of the chunk, as far as it was measured:
/// 0 for all of them, 1 where its last bytes still are.
double least_share(const EncoderInput& input, ByteSpan file, const ChunkEntry& chunk) {
    const auto error_with = [&](double share) {
        return error_of(input, file.first(chunk.offset + static_cast<std::size_t>(share * chunk.length)));
    };
    const double most = kWorse * error_with(0);
    std::size_t good = kShares.size();
    while (good > 0 && error_with(kShares[good - 1]) <= most) --good;
    if (good == 0) return 0;
    double bad = kShares[good - 1], enough = good < kShares.size() ? kShares[good] : 1;
    for (unsigned k = 0; k < kHalvings; ++k) {
        const double middle = (bad + enough) / 2;
        (error_with(middle) <= most ? enough : bad) = middle;
    }
    return std::min(enough + kMargin, 1.0);
}

}  // namespace

void say_least_bytes(const EncoderInput& input, ByteSpan file, std::vector<PlannedChunk>& plan, unsigned threads) {
    const FileHeader header = *read_header(file);
    const Toc toc = *read_toc(header, file.subspan(header.index_offset), file.size());
    const std::uint64_t vertices = vertices_of(header);
    const auto first_chunks = static_cast<std::size_t>(std::ranges::count_if(plan, starts_details));
    if (vertices * first_chunks * kShares.size() > kMostWork) return;
    std::vector<std::size_t> firsts;
    for (std::size_t i = 0; i < plan.size(); ++i)
        if (starts_details(plan[i])) firsts.push_back(i);
    std::vector<double> shares(firsts.size());
    for_each_index(firsts.size(), threads,
                   [&](std::size_t at) { shares[at] = least_share(input, file, toc.chunks[firsts[at]]); });
    for (std::size_t at = 0; at < firsts.size(); ++at) {
        const auto bytes = static_cast<std::size_t>(shares[at] * toc.chunks[firsts[at]].length);
        if (shares[at] > 0) say(bytes, plan[firsts[at]]);
    }
}

}  // namespace mvw
