// Encodes one block as embedded bit-planes; dec_block.h reads them.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "codec/bytes.h"
#include "codec/entropy/plane_coder.h"

namespace mvw {

/// One layer of a block: a chunk's payload and what it is worth.
struct EncodedPlane {
    unsigned plane = 0;
    Bytes bytes;  // may be empty: all of it follows from zeros
    /// By how much the plane lowers the sum of squared errors of each component, in that component's step^2.
    std::array<double, kMaxComponents> error_reduction{};
};

/// A block's planes from its top one, the highest that holds a 1, down to plane 0. Empty where every coefficient
/// quantises to zero: such a block has no chunks, and a block's first chunk is its top plane.
struct EncodedBlock {
    std::vector<EncodedPlane> planes;
    Entries entries;  // what the planes say; the parent of the block one level finer
};

/// scaled: shape.size() * components coefficients in units of their steps, coefficient-major, |x| < 2^28; quantised to
/// the integer towards zero. parent: EncodedBlock::entries of the same tile and channel one level below, or empty.
/// reconstruction: where in a quantisation interval the decoder puts a value (BlockDecoder::values()).
///
/// A plane can be decoded after all higher planes of its block and all higher planes of the parent block.
EncodedBlock encode_block(const BlockShape& shape, unsigned components, std::span<const float> scaled,
                          std::span<const std::uint32_t> parent, float reconstruction);

}  // namespace mvw
