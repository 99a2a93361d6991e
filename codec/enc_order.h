// Which planes form a chunk, and in which order chunks lie in the file: by error reduction per byte, as far as what
// they build on allows.
#pragma once
#include <vector>

#include "codec/container/chunk.h"
#include "codec/container/enc_file.h"
#include "codec/enc_part.h"

namespace mvw {

/// A chunk of a file to be.
struct PlannedChunk {
    ChunkId id;
    Bytes payload;
    double gain = 0;   // estimate of what it takes off the mean squared error, of the surface or of its attribute
    double error = 0;  // estimate of the mean squared surface error once it and all before it are there
    unsigned top_plane = 0, lowest_plane = 0;  // of the block, that it holds
    bool needs_parent = false;                 // planes of the parent above lowest_plane come first
};

struct OrderOptions {
    unsigned layers = 1;             // planes of the whole file: layer = layers - 1 - plane
    double least_bytes = 200;        // planes are put together until a chunk has as many, early in the file ...
    double least_share = 0.08;       // ... so much of what lies before it, and no fewer than 64
    std::size_t least_planes = 1;    // ... and so many planes, unless fewer are left
    std::vector<double> area_share;  // of each part
    double floor = 0;                // mean squared error that remeshing left
};

/// How many layers a file of these parts has: its planes, from the highest that any block holds.
unsigned layers_of(const std::vector<CodedPart>& parts);

/// Bases first, small ones before large ones. Then every plane of every block.
std::vector<PlannedChunk> order_chunks(const std::vector<CodedPart>& parts, const OrderOptions& options);

/// A block's chunk and its next one as one. Not of packed planes.
PlannedChunk join_chunks(const PlannedChunk& first, const PlannedChunk& second);

/// A Geometry chunk with no more than the first `bytes` of its planes: as if it had been cut there.
PlannedChunk beginning_of(const PlannedChunk& chunk, std::size_t bytes);

std::vector<ChunkToWrite> to_write(const std::vector<PlannedChunk>& plan);

/// Brings a plan's chunks in the order of their gains a byte, each behind what it builds on, and says their errors
/// anew. Bases stay in front.
void sort_chunks(std::vector<PlannedChunk>& plan);

}  // namespace mvw
