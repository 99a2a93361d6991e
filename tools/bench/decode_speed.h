// How fast files decode on one thread and on two: output vertices a second of .mvw files of both profiles, each against
// Draco's stream (level 7, one thread) of as many vertices that comes as near to the input; and what one more chunk
// costs.
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/mesh/mesh.h"
#include "tools/bench/table.h"

namespace mvw::bench {

/// The best of a few runs.
struct DecodeTime {
    std::string how;
    std::uint64_t bytes = 0, vertices = 0;
    double psnr = 0, seconds = 0;
};

/// What is to be timed. Arguments of the makers must outlive it.
struct Contender {
    DecodeTime time;  // no seconds yet
    std::function<void()> decode;
};
/// All of `file` from its bytes to a mesh.
Contender own_decoder(const Mesh& input, ByteSpan file, unsigned threads, const std::string& how);
/// Draco's level 7 of `mesh` at the fewest bits that come within a twentieth of a decibel of `psnr`.
Contender draco_decoder(const Mesh& input, const Mesh& mesh, double psnr);
/// Each in turn, and again, so that all of them meet the machine's good and bad moments.
void time_in_turn(std::span<Contender> contenders);
/// Mean over the chunks of the finest level of a decoder that was shown a mesh before each: chunk in, mesh out.
DecodeTime time_chunk(ByteSpan file);

struct DecodeSpeedOptions {
    std::vector<std::string> meshes;  // files
    std::string out;                  // gets decode_speed.csv
    unsigned tile_count = 16;
    std::function<void(const std::string& line)> say;
};

/// Rows of model, what, bytes, vertices, dB, milliseconds, million vertices a second, times Draco.
Result<Table> run_decode_speed(const DecodeSpeedOptions& options);

}  // namespace mvw::bench
