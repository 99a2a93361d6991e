#include "codec/enc_color.h"

#include <algorithm>
#include <cmath>

#include "codec/color.h"

namespace mvw {

namespace {

constexpr double kFinestError = 1.0 / 255;  // RMS that plane 0 leaves of a component
constexpr double kMove = 2.5;               // step of the finest vertices over what it leaves, dead zone included
// A colour error of 40 dB counts as a surface error of 70 dB: both begin to be seen there on a screen.
constexpr double kWeight = 1e-3;

std::vector<Vec3f> analyzed(const SemiRegularMesh& mesh, const std::vector<Vec3f>& values, unsigned threads) {
    std::vector<Vec3f> out(values.size());
    PatchTransform(mesh.base, mesh.levels, kColorTransform, mesh.creases, threads).analyze(values, out);
    return out;
}

}  // namespace

void code_colors(const PartPrecision& precision, unsigned threads, CodedPart& part) {
    const SemiRegularMesh& mesh = part.mesh;
    if (mesh.colors.empty()) return;
    const bool opaque = std::all_of(mesh.colors.begin(), mesh.colors.end(), [](const Rgba8& c) { return c.a == 255; });
    const std::size_t components = opaque ? 3 : 4;
    const std::vector<LevelGain> gains = synthesis_gains(kColorTransform, mesh.levels);
    part.params.color_components = static_cast<unsigned>(components);
    for (const LevelGain& gain : gains)
        part.params.color_steps.push_back(step_to_code(std::min(kFinestError * kMove / gain.normal, 1.0)));

    std::vector<Vec3f> colors, alphas;
    for (const Rgba8& c : mesh.colors) colors.push_back(to_ycocg(c));
    colors = analyzed(mesh, colors, threads);
    if (!opaque) {
        for (const Rgba8& c : mesh.colors) alphas.push_back({static_cast<float>(c.a) / 255, 0, 0});
        alphas = analyzed(mesh, alphas, threads);
    }
    const auto vertices = static_cast<double>(mesh.positions.size());
    code_blocks(part, Channel::Color, precision, [&](const BlockShape& shape, unsigned level) {
        const float step = step_from_code(part.params.color_steps[level]);
        const double gain = gains[level].normal;
        ScaledBlock scaled;
        scaled.unit.assign(components, kWeight * double{step} * step * gain * gain / vertices);
        scaled.values.reserve(shape.size() * components);
        for (const std::uint32_t v : shape.indices()) {
            const Vec3f c = level == 0 ? colors[v] - Vec3f{0.5f, 0, 0} : colors[v];
            scaled.values.insert(scaled.values.end(), {c.x / step, c.y / step, c.z / step});
            if (!opaque) scaled.values.push_back((level == 0 ? alphas[v].x - 1 : alphas[v].x) / step);
        }
        return scaled;
    });
}

}  // namespace mvw
