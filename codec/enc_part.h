// One part of a model on its way into chunks: coded base, coefficients in units of their steps, bit-planes by block.
#pragma once
#include <functional>
#include <vector>

#include "codec/dec_part.h"
#include "codec/enc_base.h"
#include "codec/entropy/enc_block.h"
#include "codec/part_units.h"

namespace mvw {

/// How finely a part is to be coded.
struct PartPrecision {
    unsigned base_bits = 9;  // of the lattice, where none is given
    unsigned tiles = 1;
    unsigned first_tiled_level = 0;     // where tiles > 1
    unsigned bare_levels = 0;           // the finest so many have no details of the shape, attributes alone
    bool supersedes = false;            // plain triangles with planes (PartInfo)
    bool alone = false;                 // Draco codes the base, as what the input has may be rough
    bool fast = false;                  // planes packed instead of range-coded
    unsigned lossless = 0;              // bits of the grid on which positions are kept exactly; 0: not so
    double error = 1e-4;                // wanted RMS surface error of the rounding alone, fraction of the diagonal
    std::vector<MaterialColor> colors;  // of materials, also of those that the part has not
    double field_error = 2e-3;          // likewise of scalar fields, fraction of a field's range
};

/// The planes of one block.
struct CodedBlock {
    Channel channel = Channel::Geometry;
    std::uint16_t tile = 0;
    std::uint8_t level = 0;
    EncodedBlock planes;
    std::vector<double> gain;  // by how much each plane lowers the part's mean squared surface error, or what counts
                               // as much in its attributes
};

struct CodedPart {
    SemiRegularMesh mesh;  // in the base's order, in units of the diagonal around the centre
    CodedBase base;
    PartParams params;
    std::vector<AttributeParams> attributes;
    std::vector<CodedBlock> blocks;  // channel by channel; tile-major, levels within, none that a tile has not
    unsigned first_tiled_level = 0;
    double tangential_share = 0;  // of the details' energy from level 2 up
    double rounding = 0;          // mean squared surface error that plane 0 leaves
};

/// Components of the coefficients of one of the part's channels.
unsigned components_of(const CodedPart& part, Channel channel);

/// Whether blocks of this level take contexts from those one level below: not where tiles begin.
bool has_parents(const CodedPart& part, unsigned level);

/// Coefficients of one block in units of their steps, and what a squared unit of each component counts.
struct ScaledBlock {
    std::vector<float> values;  // coefficient-major
    std::vector<double> unit;   // of each component
};
/// Appends all blocks of a channel. scale: from a block's shape and level. Returns what plane 0 leaves.
double code_blocks(CodedPart& part, Channel channel, const PartPrecision& precision,
                   const std::function<ScaledBlock(const BlockShape&, unsigned level)>& scale);

/// mesh: positions in units of the diagonal around the centre. base: its vertices on a lattice; or without any: then
/// these are the points nearest to the coarse positions that analysis leaves, of a lattice fitted to them.
CodedPart code_part(const SemiRegularMesh& mesh, const TransformOptions& transform, const PartPrecision& precision,
                    const Rounded& base, unsigned threads);

/// Planes alone, of plain triangles that a decoder has already, in this order.
CodedPart code_planes(const SemiRegularMesh& mesh, const PartPrecision& precision, const Rounded& base,
                      unsigned threads);

}  // namespace mvw
