// Measures what a file decodes to at points along it, and states true errors at every chunk.
#pragma once
#include <optional>
#include <vector>

#include "codec/container/toc.h"
#include "codec/decoder.h"
#include "codec/enc_input.h"
#include "codec/enc_order.h"
#include "codec/encoder.h"

namespace mvw {

/// Of all parts at their finest levels.
std::uint64_t vertices_of(const FileHeader& header);

/// Decodes planned chunks as a client would and holds what they show against the input.
class PlanDecoder {
 public:
    /// file: begins with the header.
    explicit PlanDecoder(ByteSpan file);

    void feed(const PlannedChunk& chunk);
    void feed(std::span<const PlannedChunk> chunks);
    [[nodiscard]] const FileHeader& header() const { return *decoder_.header(); }
    /// Of all that was fed; nothing while that shows nothing.
    [[nodiscard]] std::optional<SurfaceError> error(const EncoderInput& input, const SurfaceErrorOptions& sampling) const;

 private:
    Decoder decoder_;
};

/// file: of the planned chunks. Decodes it chunk after chunk as a client would, measures against `input` wherever the
/// estimate or the bytes have changed enough, and replaces each chunk's estimated mean squared error by an RMS error,
/// in the plan and in the payload's error code. Returns the whole file's error.
SurfaceError measure_errors(const EncoderInput& input, ByteSpan file, std::vector<PlannedChunk>& plan,
                            const EncodeOptions& options);

}  // namespace mvw
