// What users do today against what this codec does: the best file of a size that simplification and Draco can make
// (the LOD hull), and the prefixes of one .mvw file. Errors are those of surface_error.h against the original.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "codec/mesh/mesh.h"
#include "codec/result.h"
#include "tools/bench/table.h"

namespace mvw::bench {

/// One file, or prefix of one, and how near it comes.
struct RatePoint {
    std::uint64_t bytes = 0;
    double psnr = 0;
    std::string how;  // face share and bits, or level
};

/// Simplifies `mesh` to shares of 0.4 to 100 % of its faces, codes each with Draco's best level at 8 to 12 bits, and
/// keeps the points that no smaller file beats: rising in bytes and PSNR. Needs node with the package meshoptimizer
/// beside `simplifier`, and the program draco_encoder; Io names what is missing. scratch: a folder for its files.
Result<std::vector<RatePoint>> lod_hull(const Mesh& mesh, const std::string& simplifier, const std::string& scratch);

/// One file of a chain of levels of detail.
struct LodFile {
    std::string path;
    std::uint64_t bytes = 0;
    double psnr = 0;
};

/// What a page without progressive coding downloads one after the other: 1, 4, 16 and 100 % of the faces by Draco's
/// best level at 8, 9, 10 and 11 bits; the last one is the whole Draco file. Needs what lod_hull() needs.
Result<std::vector<LodFile>> draco_chain(const Mesh& mesh, const std::string& simplifier, const std::string& scratch);

/// Box centred, diagonal 1: in the unit that floats resolve well.
Mesh normalised(Mesh mesh);

/// Prefixes of a .mvw file from 0.1 to 6 bits per vertex of `mesh`, and the whole file.
Result<std::vector<RatePoint>> prefix_points(const Mesh& mesh, const std::string& mvw_file);

/// A model's hull out of such a csv (its rows of method "lod hull"); empty where it has none.
std::vector<RatePoint> hull_from_csv(const std::string& csv, const std::string& model);

/// The best PSNR of at most `bytes`; 0 where every point needs more.
double psnr_at(const std::vector<RatePoint>& points, std::uint64_t bytes);

struct LodHullOptions {
    std::vector<std::string> meshes;  // files
    std::string out;                  // gets lod_hull.csv and a plot NAME.svg per mesh
    std::string simplifier = "tools/bench/simplify.mjs";
    std::string hull;  // a lod_hull.csv whose hulls are taken instead of made anew; empty: none
    std::function<void(const std::string& line)> say;
};

/// Both curves for each mesh: rows of model, method, bytes, psnr, bits per vertex, gain over the hull at these bytes.
Result<Table> run_lod_hull(const LodHullOptions& options);

}  // namespace mvw::bench
