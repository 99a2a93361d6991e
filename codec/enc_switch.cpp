#include "codec/enc_switch.h"

#include <cmath>
#include <span>

#include "codec/enc_errors.h"

namespace mvw {

namespace {

constexpr std::uint32_t kSamples = 100'000;

class Switch {
 public:
    Switch(const EncoderInput& input, ByteSpan file, const std::vector<PlannedChunk>& plan, double base_error,
           unsigned threads)
        : input_(input), file_(file), plan_(plan), base_error_(base_error), threads_(threads) {}

    [[nodiscard]] std::optional<Cut> cut(std::size_t low, bool may_cut) const {
        std::size_t high = plan_.size();  // chunks that are enough; of low ones it is not known, then too few
        const double least = error_of(low);
        if (least < kAsGood * base_error_) return std::nullopt;
        if (is_good(least)) high = low;
        while (high > low + 1) {
            const std::size_t middle = low + (high - low) / 2;
            (is_good(error_of(middle)) ? high : low) = middle;
        }
        if (high == low || !is_better(error_of(high))) return Cut{high, {}};
        return Cut{low, may_cut ? part_of(low) : std::nullopt};
    }

 private:
    static constexpr double kNoFall = 1.005, kAsGood = 0.99;
    [[nodiscard]] bool is_good(double rms) const { return rms <= base_error_ * kSmallStep; }
    [[nodiscard]] bool is_better(double rms) const { return rms < base_error_ * kNoFall; }

    /// RMS error of the first chunks, and of one more.
    [[nodiscard]] double error_of(std::size_t chunks, const PlannedChunk* last = nullptr) const {
        PlanDecoder decoder(file_);
        decoder.feed(std::span(plan_).first(chunks));
        if (last) decoder.feed(*last);
        const std::optional<SurfaceError> error = decoder.error(input_, sampled(kSamples, threads_));
        return error ? error->rms : INFINITY;
    }

    /// As much of a chunk as makes the first ones good enough; nothing where one byte more or less is too large a step.
    [[nodiscard]] std::optional<PlannedChunk> part_of(std::size_t chunk) const {
        if (plan_[chunk].id.channel != Channel::Geometry) return std::nullopt;
        for (std::size_t low = 0, high = plan_[chunk].payload.size(); high > low + 1;) {
            const std::size_t middle = low + (high - low) / 2;
            PlannedChunk beginning = beginning_of(plan_[chunk], middle);
            beginning.error = error_of(chunk, &beginning);
            if (!is_good(beginning.error))
                low = middle;
            else if (is_better(beginning.error))
                high = middle;
            else
                return beginning;
        }
        return std::nullopt;
    }

    const EncoderInput& input_;
    const ByteSpan file_;
    const std::vector<PlannedChunk>& plan_;
    const double base_error_;
    const unsigned threads_;
};

}  // namespace

std::optional<Cut> cut_before(const EncoderInput& input, ByteSpan file, const std::vector<PlannedChunk>& plan,
                              std::size_t least, double base_error, bool may_cut, unsigned threads) {
    return Switch(input, file, plan, base_error, threads).cut(least, may_cut);
}

}  // namespace mvw
