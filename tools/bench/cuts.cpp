#include "tools/bench/cuts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>

#include "codec/decoder.h"
#include "codec/encoder.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/io/mesh_io.h"

namespace mvw::bench {
namespace {

constexpr std::uint32_t kSamples = 250'000;  // fewer see rises of a tenth of a decibel where there are none
constexpr double kSame = 0.01;               // dB
constexpr double kLongStep = 1.0;            // dB, between neighbours that are not all there is

/// Of the first chunks that show something.
std::size_t end_of_first(ByteSpan file) {
    const FileHeader header = read_header(file).value();
    const Toc toc = read_toc(header, file.subspan(header.index_offset), file.size()).value();
    const std::size_t shown = chunks_until_shown(toc);
    return shown > 0 ? toc.chunks[shown - 1].offset + toc.chunks[shown - 1].length : header.header_bytes;
}

void summarize(Cuts& cuts) {
    std::vector<double> seen;
    double best = 0;
    for (const RatePoint& p : cuts.points) {
        if (best > 0) cuts.largest_rise = std::max(cuts.largest_rise, best - p.psnr);
        if (best > 0) cuts.largest_step = std::max(cuts.largest_step, p.psnr - best);
        best = std::max(best, p.psnr);
        seen.push_back(p.psnr);
    }
    std::sort(seen.begin(), seen.end());
    double last = -1;
    for (const double psnr : seen)
        if (psnr >= last + kSame) last = psnr, ++cuts.qualities;
}

}  // namespace

Cuts cut(const Mesh& mesh, ByteSpan file, std::size_t count, std::uint32_t samples) {
    Cuts cuts;
    const auto measured = [&](std::size_t bytes) -> std::optional<RatePoint> {
        const Result<Mesh> prefix = decode(file.first(bytes));
        if (!prefix.ok() || !measurable(*prefix)) return std::nullopt;
        return RatePoint{bytes, surface_error(mesh, *prefix, sampled(samples, 0)).psnr, "prefix"};
    };
    // The points up to and with `to`; where they climb by much, those half-way, too.
    const std::function<void(const RatePoint&)> climb_to = [&](const RatePoint& to) {
        while (!cuts.points.empty()) {
            const RatePoint from = cuts.points.back();
            if (to.psnr <= from.psnr + kLongStep || to.bytes <= from.bytes + 1) break;
            const auto between = measured((from.bytes + to.bytes) / 2);
            if (!between) break;
            climb_to(*between);
        }
        cuts.points.push_back(to);
    };
    const auto first = static_cast<double>(end_of_first(file)), ratio = static_cast<double>(file.size()) / first;
    for (std::size_t k = 0; k < count; ++k) {
        const double share = static_cast<double>(k) / static_cast<double>(count - 1);
        const auto bytes = std::min(file.size(), static_cast<std::size_t>(std::ceil(first * std::pow(ratio, share))));
        if (const auto point = measured(bytes)) climb_to(*point);
    }
    summarize(cuts);
    return cuts;
}

Result<Table> run_cuts(const CutsOptions& options) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return Error{Errc::Io, 0, options.out + ": " + error.message()};
    Table table{{"model", "bytes", "first mesh", "first dB", "whole dB", "qualities", "largest rise dB",
                 "largest step dB", "holds"},
                {}};
    for (const std::string& path : options.meshes) {
        CleanReport report;
        Result<Mesh> mesh = read_mesh(path, report);
        if (!mesh.ok()) return mesh.error();
        const Result<Encoded> encoded = encode(*mesh, {});
        if (!encoded.ok()) return Error{encoded.error().code, 0, path + ": " + encoded.error().message};
        const Cuts cuts = cut(clean(std::move(*mesh), report), encoded->file, options.count, kSamples);
        if (cuts.points.empty()) return Error{Errc::InvalidArgument, 0, path + ": no prefix shows a surface"};
        table.rows.push_back({std::filesystem::path(path).stem().string(), std::to_string(encoded->file.size()),
                              std::to_string(cuts.points.front().bytes),
                              fmt::format("{:.2f}", cuts.points.front().psnr),
                              fmt::format("{:.2f}", cuts.points.back().psnr), std::to_string(cuts.qualities),
                              fmt::format("{:.3f}", cuts.largest_rise), fmt::format("{:.2f}", cuts.largest_step),
                              cuts.hold() ? "yes" : "no"});
        if (auto written = write_text_file(options.out + "/cuts.csv", table.csv()); !written) return written.error();
        if (options.say) options.say(table.rows.back()[0] + ": " + (cuts.hold() ? "holds" : "does not hold"));
    }
    return table;
}

}  // namespace mvw::bench
