#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "codec/measure/surface_error.h"
#include "codec/transform/transform.h"
#include "tools/paper/chart.h"
#include "tools/paper/sections.h"

namespace mvw::paper {
namespace {

constexpr std::uint32_t kSamples = 40'000;
constexpr float kTangential = 4;  // tangential steps, in normal ones
// Steps of the finest level, fractions of the diagonal; the table's is the third.
constexpr std::array<double, 5> kSteps{1.6e-2, 4e-3, 1e-3, 2.5e-4, 6e-5};
constexpr std::size_t kTableStep = 2;

/// Bits of a memoryless code for these numbers.
double entropy_bits(const std::map<int, std::size_t>& histogram) {
    double total = 0, bits = 0;
    for (const auto& [value, count] : histogram) total += double(count);
    for (const auto& [value, count] : histogram) bits -= double(count) * std::log2(double(count) / total);
    return bits;
}

struct Coded {
    std::vector<double> bits;  // of each level's details, 1 ... L
    std::vector<Vec3f> decoded;
};

/// Details quantised with a step that falls with the level's gain, normal and tangential parts coded apart.
Coded quantised(const Model& model, TransformKind kind, const std::vector<Vec3f>& coefficients, double step) {
    const unsigned L = model.mesh.levels;
    const std::vector<LevelGain> gains = synthesis_gains({.kind = kind}, L);
    Coded out{{}, coefficients};
    for (unsigned j = 1; j <= L; ++j) {
        const auto q = static_cast<float>(step * gains[L].normal / gains[j].normal);
        std::map<int, std::size_t> normal, tangential;
        for (auto v = vertices_at_level(model.mesh.base, j - 1); v < vertices_at_level(model.mesh.base, j); ++v)
            for (std::size_t c = 0; c < 3; ++c) {
                const float s = c == 0 ? q : kTangential * q;
                const float rounded = std::round(coefficients[v][c] / s);
                ++(c == 0 ? normal : tangential)[static_cast<int>(rounded)];
                out.decoded[v][c] = rounded * s;
            }
        out.bits.push_back(entropy_bits(normal) + entropy_bits(tangential));
    }
    return out;
}

double error_of(const Model& model, const Mesh& original, const std::vector<Vec3f>& positions) {
    return surface_error(original, model.surface(model.mesh.levels, positions), {kSamples, 0}).rms;
}

double decibels(double rms) {
    return -20 * std::log10(std::max(rms, 1e-12));
}

/// Bits a vertex of each transform at one quality of one model; 0 where its curve does not reach that.
struct Compared {
    double psnr = 0;
    std::array<double, kTransformCount> bits{};

    [[nodiscard]] double of(TransformKind kind) const { return bits[static_cast<std::size_t>(kind)]; }
    [[nodiscard]] TransformKind best() const {
        std::size_t best = 0;
        for (std::size_t k = 1; k < bits.size(); ++k)
            if (bits[k] > 0 && (bits[best] == 0 || bits[k] < bits[best])) best = k;
        return static_cast<TransformKind>(best);
    }
};

/// Bits a vertex at a quality, between the measured points of a curve of rising bits; none beyond its ends.
double bits_at(const Line& curve, double psnr) {
    for (std::size_t i = 1; i < curve.points.size(); ++i) {
        const auto &a = curve.points[i - 1], &b = curve.points[i];
        if (psnr < a[1] || psnr > b[1]) continue;
        const double t = (psnr - a[1]) / std::max(b[1] - a[1], 1e-9);
        return a[0] * std::pow(b[0] / a[0], t);
    }
    return 0;
}

struct Tables {
    std::vector<std::vector<std::string>> entropy, error;
};

void add_kind(Page& page, const Model& model, TransformKind kind, const Mesh& original, Chart& chart, Tables& tables) {
    const unsigned L = model.mesh.levels;
    const std::vector<Vec3f> positions = model.positions();
    const auto V = double(positions.size());
    std::vector<Vec3f> coefficients(positions.size()), out(positions.size());
    PatchTransform transform(model.mesh.base, L, {.kind = kind}, model.mesh.creases);
    transform.analyze(positions, coefficients);
    const std::string name(transform_name(kind));
    auto& numbers = page.numbers["coding"][model.name][name];
    chart.lines.push_back({name, {}});
    std::vector<std::string> row{name};
    for (std::size_t i = 0; i < kSteps.size(); ++i) {
        const Coded coded = quantised(model, kind, coefficients, kSteps[i]);
        transform.synthesize(coded.decoded, L, out);
        double bits = 0;
        for (const double b : coded.bits) bits += b;
        const double psnr = decibels(error_of(model, original, out));
        chart.lines.back().points.push_back({bits / V, psnr});
        numbers["curve"].push_back({{"step", kSteps[i]}, {"bits_per_vertex", bits / V}, {"psnr", psnr}});
        if (i != kTableStep) continue;
        for (unsigned j = 1; j <= L; ++j) {
            const auto count =
                double(vertices_at_level(model.mesh.base, j) - vertices_at_level(model.mesh.base, j - 1));
            row.push_back(fmt::format("{:.2f}", coded.bits[j - 1] / count));
            numbers["entropy_per_level"].push_back(coded.bits[j - 1] / count);
        }
        row.push_back(fmt::format("{:.2f}", bits / V));
        row.push_back(fmt::format("{:.1f}", psnr));
    }
    tables.entropy.push_back(row);
    row = {name};
    std::vector<double> rms_above;  // by level
    for (unsigned level = L; level-- > 0;) {
        std::fill(coefficients.begin() + static_cast<std::ptrdiff_t>(vertices_at_level(model.mesh.base, level)),
                  coefficients.end(), Vec3f{});
        transform.synthesize(coefficients, L, out);
        const double rms = error_of(model, original, out);
        row.insert(row.begin() + 1, fmt::format("{:.1f}", decibels(rms)));
        rms_above.insert(rms_above.begin(), rms);
    }
    numbers["rms_without_details_above"] = rms_above;
    tables.error.push_back(row);
}

/// The model at one level less where it has many: eleven transforms take a while.
Model coarser(const Model& model, unsigned levels) {
    if (model.mesh.levels <= levels) return model;
    Model out = model;
    out.mesh.levels = levels;
    out.mesh.positions.resize(vertices_at_level(model.mesh.base, levels));
    return out;
}

/// What one transform changes of another's bits, on each model.
std::string effect(const std::vector<Compared>& compared, const std::vector<Model>& models, TransformKind from,
                   TransformKind to, const char* what) {
    std::string text = fmt::format(" {} changes the bits of {} by ", what, transform_name(from));
    for (std::size_t i = 0; i < compared.size(); ++i) {
        const double a = compared[i].of(from), b = compared[i].of(to);
        const std::string change = a > 0 && b > 0 ? fmt::format("{:+.0f} %", 100 * (b / a - 1)) : "an unknown share";
        text += fmt::format("{}{} ({})", i == 0 ? "" : ", ", change, models[i].name);
    }
    return text + ".";
}

}  // namespace

Result<void> add_coding(Page& page, const std::vector<Model>& models) {
    page.heading("Beyond the paper: which transform codes best");
    page.text(
        fmt::format("Details in local frames, quantised with steps that fall with the gain of their level and are {} "
                    "times coarser along the "
                    "surface, counted by the entropy of a memoryless code for each level; the base is not counted. "
                    "Quality is the RMS "
                    "surface distance both ways, as 20 log10 (diagonal / distance). Meshes to level 4.",
                    kTangential));
    std::vector<Compared> compared;
    std::string remarks;
    for (std::size_t i = 0; i < std::min<std::size_t>(3, models.size()); ++i) {
        const Model model = coarser(models[i], 4);
        const unsigned L = model.mesh.levels;
        const Mesh original = model.surface(L, model.positions());
        Chart chart{model.name, "bits a vertex", "PSNR, dB", true, false, {}};
        Tables tables;
        for (unsigned k = 0; k < kTransformCount; ++k)
            add_kind(page, model, static_cast<TransformKind>(k), original, chart, tables);
        std::vector<std::string> head{model.name}, error_head{model.name};
        for (unsigned j = 1; j <= L; ++j) head.push_back(fmt::format("level {}", j));
        for (unsigned j = 0; j < L; ++j) error_head.push_back(fmt::format("to level {}", j));
        head.emplace_back("bits a vertex");
        head.emplace_back("dB");
        page.table(fmt::format("Entropy of {}: bits of a detail vector at a finest step of {} of the diagonal",
                               model.name, digits(kSteps[kTableStep])),
                   head, tables.entropy);
        page.table(fmt::format("Surface error of {}: dB without the details above a level", model.name), error_head,
                   tables.error);
        if (auto drawn = page.plot("coding_" + model.name, chart.svg(), "Rate and distortion, " + model.name);
            !drawn.ok())
            return drawn;
        // A quality in the middle of what interp was measured at.
        compared.push_back({(chart.lines[0].points[2][1] + chart.lines[0].points[3][1]) / 2, {}});
        Compared& here = compared.back();
        for (unsigned k = 0; k < kTransformCount; ++k) here.bits[k] = bits_at(chart.lines[k], here.psnr);
        const TransformKind best = here.best();
        page.numbers["coding"]["best"][model.name] = {{"psnr", here.psnr},
                                                      {"transform", std::string(transform_name(best))},
                                                      {"bits_per_vertex", here.of(best)},
                                                      {"interp_bits_per_vertex", here.of(TransformKind::Interp)}};
        remarks += fmt::format("{}{}: {} with {:.2f} bits a vertex at {:.1f} dB, where interp takes {:.2f}",
                               remarks.empty() ? "" : "; ", model.name, transform_name(best), here.of(best), here.psnr,
                               here.of(TransformKind::Interp));
    }
    page.verdict("Fewest bits at equal quality &mdash; " + remarks + "." +
                 effect(compared, models, TransformKind::Interp, TransformKind::Seeded,
                        "Estimating the second component from the geometry instead of resetting it, so that "
                        "quadratics too are predicted") +
                 effect(compared, models, TransformKind::Seeded, TransformKind::SeededNormal,
                        "Speaking along the normal only, which helps where a parameterisation near midpoints keeps "
                        "the tangential parts small,") +
                 effect(compared, models, TransformKind::InterpLazy, TransformKind::Interp,
                        "Lifting the paper&rsquo;s transform"));
    return {};
}

}  // namespace mvw::paper
