#include "codec/enc_end.h"

#include <algorithm>
#include <optional>

#include "codec/enc_errors.h"

namespace mvw {

namespace {

constexpr std::uint32_t kSamples = 100'000;
constexpr unsigned kSlices = 8;          // of a chunk, that are taken away one by one
constexpr double kAsNear = 1.001;        // times the least RMS error, 0.01 dB, ...
constexpr double kAsNearMax = 1.02;      // ... and times the largest distance
constexpr unsigned kMostChunks = 8;      // that go: each takes decodings of all of the file
constexpr std::size_t kLeastBytes = 64;  // of a chunk: ends of shorter ones are not worth a look

/// Of a plan's geometry; no other of its block follows this one.
std::optional<std::size_t> last_geometry(const std::vector<PlannedChunk>& plan) {
    for (std::size_t i = plan.size(); i-- > 0;)
        if (plan[i].id.channel == Channel::Geometry) return i;
    return std::nullopt;
}

/// A chunk without the last `slices` of kSlices of it.
PlannedChunk without_end(const PlannedChunk& chunk, unsigned slices) {
    return beginning_of(chunk, chunk.payload.size() * (kSlices - slices) / kSlices);
}

/// A plan's end, held against what is nearest to the input so far.
class End {
 public:
    End(const EncoderInput& input, ByteSpan file, const std::vector<PlannedChunk>& plan, unsigned threads)
        : input_(input), file_(file), plan_(plan), threads_(threads), least_(error_with(plan.size(), nullptr)) {}

    /// Whether the plan is as near with another chunk, or none, in the place of one of its own.
    bool is_as_near(std::size_t place, const PlannedChunk* instead) {
        const std::optional<SurfaceError> e = error_with(place, instead);
        if (!e || !least_ || e->rms > kAsNear * least_->rms || e->max > kAsNearMax * least_->max) return false;
        least_->rms = std::min(least_->rms, e->rms);
        return true;
    }

 private:
    [[nodiscard]] std::optional<SurfaceError> error_with(std::size_t place, const PlannedChunk* instead) const {
        PlanDecoder decoder(file_);
        for (std::size_t i = 0; i < plan_.size(); ++i) {
            if (i != place) decoder.feed(plan_[i]);
            if (i == place && instead) decoder.feed(*instead);
        }
        return decoder.error(input_, sampled(kSamples, threads_));
    }

    const EncoderInput& input_;
    const ByteSpan file_;
    const std::vector<PlannedChunk>& plan_;
    const unsigned threads_;
    std::optional<SurfaceError> least_;
};

}  // namespace

void cut_end(const EncoderInput& input, ByteSpan file, std::vector<PlannedChunk>& plan, bool whole_chunks,
             unsigned threads) {
    End end(input, file, plan, threads);
    for (unsigned chunks = 0; chunks < kMostChunks; ++chunks) {
        const std::optional<std::size_t> last = last_geometry(plan);
        if (!last) return;
        const PlannedChunk whole = plan[*last];
        const bool cuts = !whole_chunks && whole.payload.size() >= kLeastBytes;
        for (unsigned slices = 1; cuts && slices < kSlices; ++slices) {
            PlannedChunk shorter = without_end(whole, slices);
            if (!end.is_as_near(*last, &shorter)) break;
            plan[*last] = std::move(shorter);
        }
        if (!end.is_as_near(*last, nullptr)) return;
        plan.erase(plan.begin() + std::ptrdiff_t(*last));
    }
}

}  // namespace mvw
