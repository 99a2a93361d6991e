#include "codec/enc_measured_order.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "codec/enc_errors.h"
#include "codec/remesh/parallel.h"

namespace mvw {

namespace {

constexpr std::uint32_t kSamples = 10'000, kVertexStride = 30;
constexpr double kLeastError = 1e-15;              // mean squared, that is measured
constexpr unsigned kRounds = 4, kMostRounds = 12;  // the latter while those before were no more work than kMostWork
constexpr double kWorse = 1.006;       // times the least mean squared error so far, 0.026 dB: what chunks may make worse
constexpr double kLeastBetter = 0.01;  // dB in the mean, for which the order changes, ...
constexpr double kWorthAnother = 0.2;  // ... and after which another round is likely to gain something
constexpr double kMostLost = 0.05;     // dB in the mean, for chunks that are joined
constexpr double kLeastGain = 0.05;    // of its estimate, that a chunk keeps whatever is measured
constexpr std::size_t kMostWork = 20'000'000;  // vertices measured in a round

/// What a plan's beginnings decode to.
struct Course {
    std::vector<double> errors;  // mean squared, after each chunk; 1 before all bases are there
    double score = 0;            // mean PSNR over the logarithm of the bytes, from the bases to the end
};

/// Whether a plan's chunk changes what its beginnings show: the last base, and geometry.
bool is_measured(const std::vector<PlannedChunk>& plan, std::size_t i) {
    const bool is_base = plan[i].id.channel == Channel::Base;
    const bool last_base = is_base && (i + 1 == plan.size() || plan[i + 1].id.channel != Channel::Base);
    return last_base || plan[i].id.channel == Channel::Geometry;
}

constexpr double kUnknown = -1;

/// Decodes chunks [0, end) and sets the errors after those of [begin, end) that are measured.
void measure(const EncoderInput& input, ByteSpan file, const std::vector<PlannedChunk>& plan, std::size_t begin,
             std::size_t end, unsigned threads, std::vector<double>& errors) {
    if (begin == end) return;
    PlanDecoder decoder(file);
    for (std::size_t i = 0; i < end; ++i) {
        decoder.feed(plan[i]);
        if (i < begin || !is_measured(plan, i)) continue;
        const std::optional<SurfaceError> error = decoder.error(input, {kSamples, threads, kVertexStride});
        if (error) errors[i] = std::max(error->rms * error->rms, kLeastError);
    }
}

Course follow(const EncoderInput& input, ByteSpan file, const std::vector<PlannedChunk>& plan, unsigned threads) {
    Course course;
    course.errors.assign(plan.size(), kUnknown);
    // Two decoders keep two threads busier than one decoder and its measurements do. Each measurement is of all
    // vertices.
    const std::size_t middle = threads < 2 ? plan.size() : plan.size() / 2;
    side_by_side(
        threads,  //
        [&](unsigned share) { measure(input, file, plan, 0, middle, share, course.errors); },
        [&](unsigned share) { measure(input, file, plan, middle, plan.size(), share, course.errors); });
    double bytes = 0, error = 1, sum = 0, weight = 0;
    for (std::size_t i = 0; i < plan.size(); ++i) {
        const double bytes_before = std::exchange(bytes, bytes + double(plan[i].payload.size())), error_before = error;
        if (course.errors[i] != kUnknown) error = course.errors[i];
        course.errors[i] = error;
        if (plan[i].id.channel == Channel::Base) continue;
        const double width = std::log(bytes / bytes_before);
        sum -= 5 * (std::log10(error_before) + std::log10(error)) * width;
        weight += width;
    }
    course.score = weight > 0 ? sum / weight : 0;
    return course;
}

/// Gains as measured; those of attributes change as do those of the geometry before them, to stay beside it.
void correct_gains(const Course& course, std::vector<PlannedChunk>& plan) {
    double ratio = 1;
    for (std::size_t i = 1; i < plan.size(); ++i) {
        PlannedChunk& chunk = plan[i];
        if (chunk.id.channel == Channel::Geometry && chunk.gain > 0)
            ratio = std::max((course.errors[i - 1] - course.errors[i]) / chunk.gain, kLeastGain);
        if (chunk.id.channel != Channel::Base) chunk.gain *= ratio;
    }
    const auto last_base =
        std::ranges::find_if(plan, [](const PlannedChunk& c) { return c.id.channel != Channel::Base; });
    plan.front().error = course.errors[static_cast<std::size_t>(last_base - plan.begin()) - 1];
}

/// Chunks after which the surface is worse than it was come together with their blocks' next ones: a fine level's first
/// planes may fold what the coarser ones have not yet made smooth. Whether there are such.
bool join_what_is_worse(const Course& course, std::vector<PlannedChunk>& plan) {
    std::vector<double> least = course.errors;  // up to each
    for (std::size_t i = 1; i < least.size(); ++i) least[i] = std::min(least[i], least[i - 1]);
    bool any = false;
    for (std::size_t i = plan.size(); i-- > 1;) {
        const PlannedChunk& chunk = plan[i];
        const ChunkId& id = chunk.id;
        const bool is_worse = course.errors[i] > std::max(course.errors[i - 1], kWorse * least[i - 1]);
        if (id.channel != Channel::Geometry || !is_worse) continue;
        const auto is_next = [&](const PlannedChunk& c) {
            return c.id.channel == id.channel && c.id.part == id.part && c.id.tile == id.tile &&
                   c.id.level == id.level && c.top_plane + 1 == chunk.lowest_plane;
        };
        const auto next = std::find_if(plan.begin() + std::ptrdiff_t(i), plan.end(), is_next);
        if (next == plan.end()) continue;
        *next = join_chunks(chunk, *next);
        next->gain = std::max(next->gain + course.errors[i - 1] - course.errors[i], kLeastGain * next->gain);
        plan.erase(plan.begin() + std::ptrdiff_t(i));
        any = true;
    }
    return any;
}

}  // namespace

void order_by_measure(const EncoderInput& input, ByteSpan file, std::vector<PlannedChunk>& plan,
                      const EncodeOptions& options) {
    const FileHeader header = *read_header(file);
    const std::uint64_t vertices = vertices_of(header);
    const std::uint64_t work = vertices * plan.size();
    if (work > kMostWork) return;
    Course course = follow(input, file, plan, options.threads);
    bool worth_another = true;
    for (unsigned round = 0; round < kRounds || (round < kMostRounds && round * work < kMostWork); ++round) {
        std::vector<PlannedChunk> other = plan;
        correct_gains(course, other);
        const bool joins = options.profile != Profile::Fast && join_what_is_worse(course, other);
        const double least = course.score + (joins ? -kMostLost : kLeastBetter);
        if (!joins && !worth_another) return;
        sort_chunks(other);
        Course now = follow(input, file, other, options.threads);
        if (now.score < least) return;
        worth_another = joins || now.score >= course.score + kWorthAnother;
        plan = std::move(other);
        course = std::move(now);
    }
}

}  // namespace mvw
