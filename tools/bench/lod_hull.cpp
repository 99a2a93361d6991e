#include "tools/bench/lod_hull.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "codec/decoder.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tools/bench/plot.h"
#include "tools/bench/process.h"

namespace mvw::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kSamples = 200'000;
constexpr int kFewestBits = 8, kMostBits = 12;
constexpr std::size_t kShares = 25;  // from 0.4 % to 100 %, in equal ratios
constexpr int kBudgets = 24;

/// Face share number k of kShares.
double share(std::size_t k) {
    return std::pow(0.004, 1 - static_cast<double>(k) / (kShares - 1));
}

double psnr_of(const Mesh& mesh, const Mesh& other) {
    if (!measurable(other)) return 0;
    return surface_error(mesh, other, sampled(kSamples, 0)).psnr;
}

Bytes to_raw(const Mesh& mesh) {
    const std::uint32_t head[2] = {static_cast<std::uint32_t>(mesh.positions.size()),
                                   static_cast<std::uint32_t>(mesh.faces.size())};
    Bytes bytes(sizeof head + mesh.positions.size() * sizeof(Vec3f) + mesh.faces.size() * sizeof(Face));
    std::byte* at = bytes.data();
    const auto put = [&](const void* from, std::size_t n) {
        at = static_cast<std::byte*>(std::memcpy(at, from, n)) + n;
    };
    put(head, sizeof head);
    for (const Vec3& p : mesh.positions) {
        const Vec3f f = to_float(p);
        put(&f, sizeof f);
    }
    put(mesh.faces.data(), mesh.faces.size() * sizeof(Face));
    return bytes;
}

Result<Mesh> from_raw(const std::string& path) {
    const auto bytes = read_file(path);
    if (!bytes) return bytes.error();
    ByteReader in(*bytes);
    const std::uint64_t V = in.u32(), F = in.u32();
    if (in.remaining() != V * sizeof(Vec3f) + F * sizeof(Face)) return Error{Errc::Malformed, 0, path + ": wrong size"};
    Mesh mesh;
    for (std::uint64_t v = 0; v < V; ++v) {
        const double x = in.f32(), y = in.f32(), z = in.f32();
        mesh.positions.push_back({x, y, z});
    }
    for (std::uint64_t f = 0; f < F; ++f) {
        const std::uint32_t a = in.u32(), b = in.u32(), c = in.u32();
        mesh.faces.push_back({a, b, c});
    }
    return mesh;
}

Result<void> run_or_explain(const std::vector<std::string>& arguments, const char* need) {
    const auto run = run_process(arguments);
    if (!run) return Error{Errc::Io, 0, run.error().message + " (" + need + ")"};
    if (run->exit_code != 0) return Error{Errc::Io, 0, arguments[0] + " failed: " + run->errors + " (" + need + ")"};
    return {};
}

Result<void> simplify(const Mesh& mesh, const std::string& simplifier, const std::string& scratch,
                      const std::vector<double>& shares) {
    if (auto written = write_file(scratch + "/input.raw", to_raw(mesh)); !written) return written.error();
    std::vector<std::string> arguments{"node", simplifier, scratch + "/input.raw", scratch + "/lod"};
    for (const double s : shares) arguments.push_back(fmt::format("{:.6f}", s));
    return run_or_explain(arguments, "needs node, and npm install in tools/bench");
}

/// What the simplifier wrote as number k, as a mesh file; no name where nothing was left of the mesh.
Result<std::string> lod_as_ply(const std::string& scratch, std::size_t k) {
    const auto lod = from_raw(fmt::format("{}/lod{}.raw", scratch, k));
    if (!lod) return lod.error();
    if (lod->faces.empty()) return std::string();
    std::string file = fmt::format("{}/lod{}.ply", scratch, k);
    if (auto written = write_mesh(file, *lod); !written) return written.error();
    return file;
}

/// Codes `lod` with `bits` and measures what comes back.
Result<RatePoint> draco_point(const Mesh& mesh, const std::string& lod_file, int bits, double of_faces) {
    const std::string coded = lod_file + ".drc", decoded = lod_file + ".decoded.ply";
    const char* need = "needs the package draco";
    if (auto run = run_or_explain(
            {"draco_encoder", "-i", lod_file, "-o", coded, "-qp", std::to_string(bits), "-cl", "10"}, need);
        !run)
        return run.error();
    if (auto run = run_or_explain({"draco_decoder", "-i", coded, "-o", decoded}, need); !run) return run.error();
    CleanReport report;
    const auto back = read_mesh(decoded, report);
    if (!back) return back.error();
    return RatePoint{fs::file_size(coded), psnr_of(mesh, *back), fmt::format("{:.2f} % {} bits", 100 * of_faces, bits)};
}

/// Drops what a smaller or equal file beats.
std::vector<RatePoint> keep_best(std::vector<RatePoint> points) {
    std::sort(points.begin(), points.end(), [](const RatePoint& a, const RatePoint& b) {
        return a.bytes != b.bytes ? a.bytes < b.bytes : a.psnr > b.psnr;
    });
    std::vector<RatePoint> best;
    for (RatePoint& p : points)
        if (best.empty() || p.psnr > best.back().psnr) best.push_back(std::move(p));
    return best;
}

Curve curve_of(const std::string& name, const std::vector<RatePoint>& points) {
    Curve curve{name, {}};
    for (const RatePoint& p : points) curve.points.push_back({static_cast<double>(p.bytes), p.psnr});
    return curve;
}

struct Curves {
    std::vector<RatePoint> hull, ours;
    std::size_t vertices = 0;
};

/// That of the csv where it has one, else a new one.
Result<std::vector<RatePoint>> hull_of(const Mesh& mesh, const std::string& model, const LodHullOptions& options,
                                       const std::string& scratch) {
    if (!options.hull.empty()) {
        const auto bytes = read_file(options.hull);
        if (!bytes) return bytes.error();
        auto known = hull_from_csv({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, model);
        if (!known.empty()) return known;
    }
    return lod_hull(mesh, options.simplifier, scratch);
}

Result<Curves> measure(const std::string& file, const LodHullOptions& options, const std::string& scratch) {
    CleanReport report;
    auto read = read_mesh(file, report);
    if (!read) return read.error();
    read->fields.clear();  // the hull's files hold shape alone
    const Mesh mesh = normalised(clean(std::move(read).value(), report));
    if (!measurable(mesh)) return Error{Errc::InvalidArgument, 0, file + ": nothing to measure"};
    Curves curves;
    curves.vertices = mesh.positions.size();
    if (auto hull = hull_of(mesh, fs::path(file).stem().string(), options, scratch))
        curves.hull = std::move(hull).value();
    else
        return hull.error();
    // The codec gets the normalised mesh, too, so that both are measured against one surface.
    const std::string input = scratch + "/input.ply", coded = scratch + "/coded.mvw";
    if (auto written = write_mesh(input, mesh); !written) return written.error();
    if (auto run = run_or_explain({own_program(), "encode", input, coded}, "mvw encode"); !run) return run.error();
    auto ours = prefix_points(mesh, coded);
    if (!ours) return ours.error();
    curves.ours = std::move(ours).value();
    return curves;
}

void add_rows(Table& table, const std::string& name, const Curves& curves) {
    const auto add = [&](const char* method, const RatePoint& p) {
        const double hull = psnr_at(curves.hull, p.bytes);
        table.rows.push_back(
            {name, method, std::to_string(p.bytes), fmt::format("{:.2f}", p.psnr),
             fmt::format("{:.3f}", 8.0 * static_cast<double>(p.bytes) / static_cast<double>(curves.vertices)),
             hull > 0 ? fmt::format("{:.2f}", p.psnr - hull) : "", p.how});
    };
    for (const RatePoint& p : curves.hull) add("lod hull", p);
    for (const RatePoint& p : curves.ours) add("mvw", p);
}

}  // namespace

Result<std::vector<RatePoint>> lod_hull(const Mesh& mesh, const std::string& simplifier, const std::string& scratch) {
    std::vector<double> shares;
    for (std::size_t k = 0; k < kShares; ++k) shares.push_back(share(k));
    if (auto run = simplify(mesh, simplifier, scratch, shares); !run) return run.error();
    std::vector<RatePoint> points;
    for (std::size_t k = 0; k < kShares; ++k) {
        const auto file = lod_as_ply(scratch, k);
        if (!file) return file.error();
        if (file->empty()) continue;
        for (int bits = kFewestBits; bits <= kMostBits; ++bits) {
            auto point = draco_point(mesh, *file, bits, share(k));
            if (!point) return point.error();
            points.push_back(std::move(point).value());
        }
    }
    return keep_best(std::move(points));
}

Mesh normalised(Mesh mesh) {
    const Box box = bounding_box(mesh);
    for (Vec3& p : mesh.positions) p = (p - box.center()) / box.diagonal();
    return mesh;
}

Result<std::vector<LodFile>> draco_chain(const Mesh& mesh, const std::string& simplifier, const std::string& scratch) {
    const std::vector<double> shares{0.01, 0.04, 0.16, 1};
    if (auto run = simplify(mesh, simplifier, scratch, shares); !run) return run.error();
    std::vector<LodFile> chain;
    for (std::size_t k = 0; k < shares.size(); ++k) {
        const auto file = lod_as_ply(scratch, k);
        if (!file) return file.error();
        if (file->empty()) continue;
        const auto point = draco_point(mesh, *file, kFewestBits + static_cast<int>(k), shares[k]);
        if (!point) return point.error();
        chain.push_back({*file + ".drc", point->bytes, point->psnr});
    }
    return chain;
}

Result<std::vector<RatePoint>> prefix_points(const Mesh& mesh, const std::string& mvw_file) {
    const auto file = read_file(mvw_file);
    if (!file) return file.error();
    std::vector<RatePoint> points;
    for (int k = 0; k <= kBudgets; ++k) {
        const double bits = 0.1 * std::pow(60.0, static_cast<double>(k) / kBudgets);
        const auto bytes = static_cast<std::uint64_t>(bits / 8 * static_cast<double>(mesh.positions.size()));
        if (bytes >= file->size()) break;
        const auto prefix = decode(ByteSpan(*file).first(bytes));
        if (prefix) points.push_back({bytes, psnr_of(mesh, *prefix), "prefix"});
    }
    const auto whole = decode(*file);
    if (!whole) return whole.error();
    points.push_back({file->size(), psnr_of(mesh, *whole), "whole file"});
    return points;
}

std::vector<RatePoint> hull_from_csv(const std::string& csv, const std::string& model) {
    const std::string start = model + ",lod hull,";
    std::vector<RatePoint> points;
    std::istringstream lines(csv);
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with(start)) continue;
        RatePoint point;
        char comma = 0;
        std::istringstream cells(line.substr(start.size()));
        if (cells >> point.bytes >> comma >> point.psnr) points.push_back(point);
    }
    return points;
}

double psnr_at(const std::vector<RatePoint>& points, std::uint64_t bytes) {
    double best = 0;
    for (const RatePoint& p : points)
        if (p.bytes <= bytes) best = std::max(best, p.psnr);
    return best;
}

Result<Table> run_lod_hull(const LodHullOptions& options) {
    const std::string scratch = options.out + "/scratch";
    std::error_code error;
    fs::create_directories(scratch, error);
    if (error) return Error{Errc::Io, 0, scratch + ": " + error.message()};
    Table table{{"model", "method", "bytes", "psnr", "bits per vertex", "gain", "how"}, {}};
    for (const std::string& file : options.meshes) {
        const std::string name = fs::path(file).stem().string();
        const auto curves = measure(file, options, scratch);
        if (!curves) return curves.error();
        add_rows(table, name, *curves);
        const Plot plot{
            name, "bytes", "PSNR, dB", {curve_of("simplify + Draco", curves->hull), curve_of("mvw", curves->ours)}};
        if (auto written = write_text_file(options.out + "/" + name + ".svg", plot.svg()); !written)
            return written.error();
        if (auto written = write_text_file(options.out + "/lod_hull.csv", table.csv()); !written)
            return written.error();
        if (options.say)
            options.say(
                fmt::format("{}: {} points on the hull, {} of mvw", name, curves->hull.size(), curves->ours.size()));
    }
    fs::remove_all(scratch, error);
    return table;
}

}  // namespace mvw::bench
