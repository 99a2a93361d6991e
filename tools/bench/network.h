// How soon a model is on the screen over a real network's speeds and distances: the stream against the whole Draco file
// and against a chain of Draco files.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "codec/result.h"
#include "tools/bench/table.h"

namespace mvw::bench {

struct NetworkOptions {
    std::vector<std::string> meshes;  // files
    std::string out;                  // gets network.csv, network.md and a plot NAME.svg per mesh
    std::string simplifier = "tools/bench/simplify.mjs";
    std::vector<double> megabits = {1, 5, 20};
    std::vector<int> round_trips_ms = {20, 100, 300};
    std::size_t runs = 3;  // over each link; medians count
    std::function<void(const std::string& line)> say;
};

/// For each mesh, rate and distance, all of them through the shaper: seconds to the first mesh and to 60 dB by the
/// stream, to 60 dB by the chain (all files asked for at once on one connection, the best case), and to the end of the
/// whole Draco file; what the aim allows, and whether it is met. Times are those at which a mesh is made, ours and
/// Draco's; how good it is has been measured against the input afterwards.
///
/// Aims: first mesh within 2 round trips, its bytes at link rate and 0.1 s; 60 dB within a third of the time of the
/// whole Draco file where that takes more than 5 round trips at link rate, else never later than it.
Result<Table> run_network(const NetworkOptions& options);

}  // namespace mvw::bench
