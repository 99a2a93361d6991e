#include "codec/entropy/enc_block.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "codec/entropy/enc_range_coder.h"

namespace mvw {

namespace {

std::uint32_t quantized_entry(float x) {
    constexpr float kLargest = 268435440.0f;  // below 2^kMaxPlanes
    const auto magnitude = static_cast<std::uint32_t>(std::min(std::abs(x), kLargest));
    return magnitude == 0 ? 0 : 2 * magnitude + std::uint32_t{x < 0};
}

/// Answers a PlaneCoder with the truth and writes it.
class PlaneWriter {
 public:
    explicit PlaneWriter(const Entries& truth) : truth_(truth) {}

    bool code(std::uint32_t probability, bool truth) {
        encoder_.encode(truth, probability);
        return truth;
    }
    [[nodiscard]] bool any(std::size_t first, std::size_t last, unsigned plane) const {
        std::uint32_t all = 0;
        for (std::size_t at = first; at < last; ++at) all |= truth_[at];
        return magnitude_of(all) >> plane != 0;
    }
    [[nodiscard]] std::uint32_t truth(std::size_t at) const { return truth_[at]; }
    [[nodiscard]] static constexpr bool stopped() { return false; }
    Bytes finish() { return encoder_.finish(); }

 private:
    const Entries& truth_;
    RangeEncoder encoder_;
};

double squared(double x) {
    return x * x;
}

/// What is left of x's squared error once the planes from `plane` up are known.
double error_with_plane(double x, std::uint32_t magnitude, unsigned plane, double reconstruction) {
    const std::uint32_t known = magnitude >> plane;
    return squared(x - (known == 0 ? 0.0 : std::ldexp(known + reconstruction, static_cast<int>(plane))));
}

}  // namespace

EncodedBlock encode_block(const BlockShape& shape, unsigned components, std::span<const float> scaled,
                          std::span<const std::uint32_t> parent, float reconstruction) {
    assert(components >= 1 && components <= kMaxComponents && scaled.size() == shape.size() * components);
    EncodedBlock block;
    Entries truth(scaled.size());
    std::transform(scaled.begin(), scaled.end(), truth.begin(), quantized_entry);
    std::uint32_t largest = 0;
    for (const std::uint32_t entry : truth) largest = std::max(largest, magnitude_of(entry));
    const EntryRows parent_rows = rows_of(parent, components);
    BlockProgress progress(shape.size(), components);
    progress.top = static_cast<unsigned>(std::bit_width(largest)) - 1;
    for (unsigned plane = progress.top + 1; plane-- > 0;) {
        PlaneWriter writer(truth);
        PlaneCoder(shape, std::span<const EntryRow>(parent_rows), plane, progress, writer).run();
        EncodedPlane& out = block.planes.emplace_back();
        out.plane = plane;
        out.bytes = writer.finish();
        for (std::size_t at = 0; at < scaled.size(); ++at) {
            const double x = std::abs(scaled[at]);
            const std::uint32_t magnitude = magnitude_of(truth[at]);
            out.error_reduction[at % components] += error_with_plane(x, magnitude, plane + 1, reconstruction) -
                                                    error_with_plane(x, magnitude, plane, reconstruction);
        }
    }
    block.entries = std::move(truth);
    return block;
}

}  // namespace mvw
