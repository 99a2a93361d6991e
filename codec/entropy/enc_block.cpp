#include "codec/entropy/enc_block.h"

#include <cassert>
#include <cmath>

#include "codec/entropy/enc_range_coder.h"

namespace mvw {

namespace {

std::uint32_t quantized_entry(float x) {
    const auto magnitude = static_cast<std::uint32_t>(std::min(std::abs(x), 2147483520.0f));
    return magnitude == 0 ? 0 : 2 * magnitude + std::uint32_t{x < 0};
}

/// Answers code_plane() with the truth and writes it.
class PlaneWriter {
 public:
    explicit PlaneWriter(const Magnitudes& truth) : truth_(truth) {}

    bool code(AdaptiveBit& model, std::size_t at, unsigned plane) {
        const bool bit = (magnitude_of(truth_[at]) >> plane & 1u) != 0;
        encoder_.encode(bit, model.probability());
        model.learn(bit);
        return bit;
    }
    bool code_sign(std::size_t at) {
        const bool negative = (truth_[at] & 1u) != 0;
        encoder_.encode(negative, 1u << (kProbabilityBits - 1));
        return negative;
    }
    [[nodiscard]] static constexpr bool stopped() { return false; }
    Bytes finish() { return encoder_.finish(); }

 private:
    const Magnitudes& truth_;
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
    Magnitudes truth(scaled.size());
    std::transform(scaled.begin(), scaled.end(), truth.begin(), quantized_entry);
    std::uint32_t largest = 0;
    for (const std::uint32_t entry : truth) largest = std::max(largest, magnitude_of(entry));
    block.entries.assign(scaled.size(), 0);
    PlaneModel model;
    for (unsigned plane = static_cast<unsigned>(std::bit_width(largest)); plane-- > 0;) {
        PlaneWriter writer(truth);
        code_plane(shape, components, plane, model, parent, block.entries, writer);
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
    return block;
}

}  // namespace mvw
