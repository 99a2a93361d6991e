// What the promise of scalability is worth on real files: one .mvw file cut at 200 places, each prefix decoded and
// measured. More bytes must never raise the error by more than 0.05 dB, and at least 100 different qualities must lie
// in a file, in steps of at most 1 dB.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "codec/bytes.h"
#include "codec/mesh/mesh.h"
#include "tools/bench/lod_hull.h"

namespace mvw::bench {

/// What 200 prefixes of a file show.
struct Cuts {
    std::vector<RatePoint> points;  // rising in bytes; the first is the shortest prefix that shows a mesh
    double largest_rise = 0;        // of the error where bytes were added, dB: the best before against what came
    double largest_step = 0;        // fall of the error between neighbours, dB
    std::size_t qualities = 0;      // values of PSNR that differ by a hundredth of a decibel or more

    [[nodiscard]] bool hold() const { return largest_rise <= 0.05 && largest_step <= 1 && qualities >= 100; }
};

/// Cuts `file` at `count` sizes in equal ratios from its first mesh to its end, and between two of them that lie more
/// than 1 dB apart half-way, again and again: on steep ground a fiftieth more bytes are several steps. samples: a side,
/// for each measurement.
Cuts cut(const Mesh& mesh, ByteSpan file, std::size_t count, std::uint32_t samples);

struct CutsOptions {
    std::vector<std::string> meshes;  // files
    std::string out;                  // gets cuts.csv
    std::size_t count = 200;
    std::function<void(const std::string& line)> say;
};

/// Encodes each mesh with default options and cuts it: rows of model, file bytes, first mesh (bytes, dB), whole file's
/// dB, qualities, largest rise, largest step, whether the promise holds.
Result<Table> run_cuts(const CutsOptions& options);

}  // namespace mvw::bench
