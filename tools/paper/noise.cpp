#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "client/viewer/picture.h"
#include "codec/transform/transform.h"
#include "tools/paper/chart.h"
#include "tools/paper/sections.h"

namespace mvw::paper {
namespace {

constexpr double kSigma = 0.003;  // of the diagonal, each coordinate
constexpr unsigned kSide = 260;   // pixels of one picture

struct Kind {
    TransformKind kind;
    const char *name, *caption;
};
constexpr std::array<Kind, 4> kKinds{{{TransformKind::Loop, "loop, lifted (10 points)", "loop"},
                                      {TransformKind::InterpLazy, "interpolatory, lazy", "interp-lazy"},
                                      {TransformKind::Interp, "interpolatory, lifted", "interp"},
                                      {TransformKind::LoopLazy, "loop, lazy", "loop-lazy"}}};
constexpr std::size_t kShown = 3;  // of them in the figures: lazy Loop runs off the scale

std::vector<Vec3f> with_noise(const std::vector<Vec3f>& clean) {
    std::mt19937 random(7);
    std::normal_distribution<float> normal(0, static_cast<float>(kSigma));
    std::vector<Vec3f> out = clean;
    for (Vec3f& p : out) p += Vec3f{normal(random), normal(random), normal(random)};
    return out;
}

double rms(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += double(squared_length(a[i] - b[i]));
    return std::sqrt(sum / double(a.size()));
}

/// Low-pass versions of the noisy mesh: level k without the details above it, k = L ... 0.
std::vector<std::vector<Vec3f>> low_pass(const Model& model, TransformKind kind, const std::vector<Vec3f>& noisy) {
    const unsigned L = model.mesh.levels;
    PatchTransform transform(model.mesh.base, L, {.kind = kind, .local_frames = false}, model.mesh.creases);
    std::vector<Vec3f> coefficients(noisy.size());
    transform.analyze(noisy, coefficients);
    std::vector<std::vector<Vec3f>> out;
    for (unsigned k = L + 1; k-- > 0;) {
        std::fill(coefficients.begin() + static_cast<std::ptrdiff_t>(vertices_at_level(model.mesh.base, k)),
                  coefficients.end(), Vec3f{});
        out.emplace_back(noisy.size());
        transform.synthesize(coefficients, L, out.back());
    }
    return out;
}

/// One row of pictures for each of the shown kinds.
Result<Image> sequence(const Model& model, const std::vector<std::vector<std::vector<Vec3f>>>& rows) {
    const unsigned L = model.mesh.levels, drawn = std::min(L, 4u);
    PictureOptions options;
    options.width = options.height = kSide;
    options.camera = fit_camera(model.surface(drawn, rows[0][0]), options.yaw, options.pitch, 1);
    std::vector<SheetEntry> entries;
    for (std::size_t row = 0; row < rows.size(); ++row)
        for (unsigned i = 0; i <= L; ++i) {
            Result<Image> image = draw_picture(model.surface(drawn, rows[row][i]), options);
            if (!image.ok()) return image.error();
            entries.push_back({std::move(*image), fmt::format("{}, level {}", kKinds[row].caption, L - i)});
        }
    return contact_sheet(entries, L + 1);
}

/// How the paper's two claims fare, over all models.
struct Counts {
    unsigned points = 0, beats_loop = 0, beats_lazy = 0;
    bool loop_diverges = true;    // lazy Loop: each analysis adds error, everywhere
    std::string least, exceeded;  // by model: where interp's error is least; where it ends above the noise
};

Result<void> add_model(Page& page, const Model& model, Counts& counts, std::vector<std::vector<std::string>>& cells) {
    const unsigned L = model.mesh.levels;
    const std::vector<Vec3f> clean = model.positions(), noisy = with_noise(clean);
    Chart chart{model.name, "analyses", "L2 error, 1e-3 of the diagonal", false, false, {}};
    std::vector<std::vector<std::vector<Vec3f>>> rows;
    std::vector<std::vector<double>> errors;
    for (std::size_t k = 0; k < kKinds.size(); ++k) {
        rows.push_back(low_pass(model, kKinds[k].kind, noisy));
        std::vector<std::string> row{fmt::format("{}, {}", model.name, kKinds[k].name)};
        errors.emplace_back();
        for (const auto& positions : rows.back()) {
            errors.back().push_back(rms(positions, clean));
            row.push_back(digits(errors.back().back() * 1e3));
        }
        cells.push_back(row);
        page.numbers["noise"]["rms"][model.name][std::string(transform_name(kKinds[k].kind))] = errors.back();
        if (k >= kShown) continue;
        chart.lines.push_back({kKinds[k].caption, {}});
        for (std::size_t i = 0; i < errors.back().size(); ++i)
            chart.lines.back().points.push_back({double(i), errors.back()[i] * 1e3});
    }
    for (unsigned i = 1; i <= L; ++i) {
        ++counts.points;
        counts.beats_loop += errors[2][i] < errors[0][i] ? 1 : 0;
        counts.beats_lazy += errors[2][i] < errors[1][i] ? 1 : 0;
    }
    const std::vector<double>& own = errors[2];
    const auto least = std::min_element(own.begin(), own.end());
    counts.least += fmt::format("{}{} after {} ({} of the noise)", counts.least.empty() ? "" : ", ", model.name,
                                least - own.begin(), digits(*least / own[0], 2));
    if (own[L] > own[0])
        counts.exceeded +=
            fmt::format("{}{} ({} times)", counts.exceeded.empty() ? "" : ", ", model.name, digits(own[L] / own[0], 2));
    counts.loop_diverges = counts.loop_diverges && std::is_sorted(errors[3].begin(), errors[3].end());
    if (auto written = page.plot("noise_" + model.name, chart.svg(), "Figure 7, " + model.name); !written.ok())
        return written;
    rows.resize(kShown);
    const Result<Image> picture = sequence(model, rows);
    if (!picture.ok()) return picture.error();
    return write_png(page.path("noise_sequence_" + model.name + ".png"), *picture);
}

std::string verdict_on(const Counts& counts) {
    std::string text = fmt::format(
        "Lifted interpolatory wavelets have the smaller error than lazy ones at {} of {} levels and than "
        "10-point Loop at {} of {}.",
        counts.beats_lazy, counts.points, counts.beats_loop, counts.points);
    text += counts.beats_lazy + counts.beats_loop == 2 * counts.points
                ? " The paper&rsquo;s order holds on every model and level."
                : " Where the paper&rsquo;s order fails, it is the model that decides: see the table.";
    text += fmt::format(" Its error is least on {}; from there on more of the shape is lost than of the noise removed.",
                        counts.least);
    text += counts.exceeded.empty()
                ? " It stays below the noise to the last analysis, as the paper says."
                : fmt::format(
                      " That errors do not increase much holds for few analyses only: after the last one they "
                      "are larger than the noise itself on {}, whose base cannot hold the shape.",
                      counts.exceeded);
    if (counts.loop_diverges)
        text +=
            " Lazy Loop, which the paper does not show, is unstable: its errors grow with every analysis, since each "
            "inverts an averaging without a lift.";
    return text;
}

}  // namespace

Result<void> add_noise(Page& page, const std::vector<Model>& models) {
    page.heading("Figures 7 and 8: noise filtering");
    page.quote(
        "&ldquo;compared with loop subdivision wavelet and lazy interpolatory subdivision wavelet, the interpolatory "
        "subdivision wavelet has better performance in noise reduction.&rdquo; And: &ldquo;the error rates don&rsquo;t "
        "increase much after few wavelet analysis operations.&rdquo;");
    page.text(
        fmt::format("White noise of {} of the diagonal in each coordinate on all vertices, {} analyses, then "
                    "synthesis to the finest level without the details above level k. The error is the RMS distance of "
                    "vertices from those of the clean mesh. The paper does not tell its noise level.",
                    kSigma, models.front().mesh.levels));
    page.numbers["noise"]["sigma"] = kSigma;
    Counts counts;
    std::vector<std::vector<std::string>> cells;
    for (const Model& model : models)
        if (auto done = add_model(page, model, counts, cells); !done.ok()) return done;
    std::vector<std::string> head{"L2 error after so many analyses"};
    for (unsigned i = 0; i <= models.front().mesh.levels; ++i) head.push_back(std::to_string(i));
    page.table("Thousandths of the diagonal", head, cells);
    for (const Model& model : models)
        page.show(
            "noise_sequence_" + model.name + ".png",
            "Figure 8, " + model.name + ": low-pass versions of the noisy mesh, one row a transform, levels falling");
    page.numbers["noise"]["counts"] = {
        {"points", counts.points}, {"interp_beats_loop", counts.beats_loop}, {"interp_beats_lazy", counts.beats_lazy}};
    page.verdict(verdict_on(counts));
    return {};
}

}  // namespace mvw::paper
