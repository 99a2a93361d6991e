// Where one stage of a file ends and the next one begins.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "codec/enc_input.h"
#include "codec/enc_order.h"

namespace mvw {

/// Times an RMS error: most of a decibel (1.122).
inline constexpr double kSmallStep = 1.09;

/// What stays of a plan before a stage that follows.
struct Cut {
    std::size_t chunks = 0;
    std::optional<PlannedChunk> beginning;  // of the next chunk
};

/// The shortest beginning of a plan that is about as good as the base of what follows, and no better: that would be
/// worse. file: begins with the header. least: so many chunks stay in any case. may_cut: it may end inside a chunk, so
/// that the step to the base is a small one. Nothing where the least is better already.
std::optional<Cut> cut_before(const EncoderInput& input, ByteSpan file, const std::vector<PlannedChunk>& plan,
                              std::size_t least, double base_error, bool may_cut, unsigned threads);

}  // namespace mvw
