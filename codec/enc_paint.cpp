#include "codec/enc_paint.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/mesh/srgb.h"
#include "codec/mesh/vertex_data.h"
#include "codec/remesh/parallel.h"
#include "codec/transform/stencils.h"

namespace mvw {

namespace {

// What vertices may leave out: RMS of a colour's component in [0, 1], 36 dB, ...
constexpr double kShown = 0.015;
// ... 30 dB where edges are a 500th of the diagonal (borders between areas of one colour leave something on any level),
// ...
constexpr double kNearlyShown = 0.03, kShortEdge = 1.0 / 500;
// ... or anything between vertices that a picture of the whole model cannot show apart.
constexpr double kPixel = 1.0 / 1000;

constexpr std::size_t kManyVertices = 1'000'000;

using Light = std::array<double, 4>;  // red, green, blue (linear), alpha

/// A surface whose levels are added one by one, without details.
class GrowingSurface {
 public:
    /// part: of at least one level.
    GrowingSurface(const SemiRegularMesh& part, const TransformOptions& options, unsigned threads)
        : part_(part), options_(options), threads_(threads), level_(part.levels), positions_(part.positions) {
        std::vector<Vec3f> in(positions_.size());
        std::ranges::transform(positions_, in.begin(), to_float);
        coefficients_.resize(in.size());
        transform(level_).analyze(in, coefficients_);
    }
    [[nodiscard]] unsigned level() const { return level_; }
    [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }
    void add_level() {
        ++level_;
        coefficients_.resize(vertices_at_level(part_.base, level_));
        std::vector<Vec3f> out(coefficients_.size());
        transform(level_).synthesize(coefficients_, level_, out);
        for (std::size_t v = positions_.size(); v < out.size(); ++v) positions_.push_back(to_double(out[v]));
    }

 private:
    [[nodiscard]] PatchTransform transform(unsigned levels) const {
        return PatchTransform(part_.base, levels, options_, part_.creases, threads_);
    }
    const SemiRegularMesh& part_;
    const TransformOptions& options_;
    const unsigned threads_;
    unsigned level_;
    std::vector<Vec3> positions_;
    std::vector<Vec3f> coefficients_;
};

/// Both ends of the edge that each new vertex of a level splits; of those from `first` on.
std::vector<std::array<std::uint32_t, 2>> ends_of(std::span<const Face> triangles, std::size_t first,
                                                  std::size_t vertices) {
    std::vector<std::array<std::uint32_t, 2>> ends(vertices - first, {kNone, kNone});
    for (const Face& f : triangles)
        for (unsigned c = 0; c < 3; ++c)
            for (const std::uint32_t end : {f[(c + 1) % 3], f[(c + 2) % 3]}) {
                if (f[c] < first || end >= first) continue;
                auto& of = ends[f[c] - first];
                if (of[0] == kNone || of[0] == end)
                    of[0] = end;
                else
                    of[1] = end;
            }
    for (auto& of : ends)
        if (of[1] == kNone) of[1] = of[0];
    return ends;
}

/// Colours of a level's vertices by what was sampled at these and in the middle of their edges.
std::vector<Light> filtered(const std::vector<Light>& samples, std::span<const std::array<std::uint32_t, 2>> ends) {
    const std::size_t count = samples.size() - ends.size();
    std::vector<Light> out(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(count));
    std::vector<double> weight(count, 1);
    for (std::size_t o = 0; o < ends.size(); ++o)
        for (const std::uint32_t v : ends[o]) {
            for (std::size_t k = 0; k < 4; ++k) out[v][k] += samples[count + o][k] / 2;
            weight[v] += 0.5;
        }
    for (std::size_t v = 0; v < count; ++v)
        for (double& x : out[v]) x /= weight[v];
    return out;
}

/// Mean length of the edges with these ends.
double mean_edge(const std::vector<Vec3>& positions, std::span<const std::array<std::uint32_t, 2>> ends) {
    double sum = 0;
    for (const auto& [a, b] : ends) sum += length(positions[a] - positions[b]);
    return sum / static_cast<double>(std::max<std::size_t>(ends.size(), 1));
}

/// RMS of what colours between vertices differ by from those in the middle of their edges.
double left_out(const std::vector<Rgba8>& colors, const std::vector<Light>& samples,
                std::span<const std::array<std::uint32_t, 2>> ends) {
    double sum = 0;
    for (std::size_t o = 0; o < ends.size(); ++o) {
        const Rgba8 &a = colors[ends[o][0]], &b = colors[ends[o][1]], is = to_srgb(samples[colors.size() + o]);
        for (const double d : {(a.r + b.r) / 2.0 - is.r, (a.g + b.g) / 2.0 - is.g, (a.b + b.b) / 2.0 - is.b})
            sum += d * d / 3;
    }
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(ends.size(), 1))) / 255;
}

/// Gives new vertices the means of their edges' ends.
void extend_fields(SemiRegularMesh& mesh, std::span<const std::array<std::uint32_t, 2>> ends) {
    for (VertexField& field : mesh.fields)
        for (const auto& [a, b] : ends) append_mean(field, std::array{VertexShare{a, 0.5}, VertexShare{b, 0.5}}, field);
}

}  // namespace

Painter::Painter(const Paintwork& paintwork, const Vec3& center, double diagonal, unsigned threads)
    : paintwork_(paintwork),
      center_(center),
      diagonal_(diagonal),
      index_(paintwork.surface().positions, paintwork.surface().faces, threads) {}

std::vector<Light> Painter::sample(std::span<const Vec3> positions, unsigned threads) const {
    std::vector<Light> light(positions.size());
    parallel_slices(positions.size(), threads, [&](std::size_t begin, std::size_t end) {
        std::uint32_t near = kNone;
        for (std::size_t v = begin; v < end; ++v) {
            const SurfacePoint at = index_.closest(center_ + positions[v] * diagonal_, near);
            near = at.face;
            light[v] = paintwork_.at(at.face, at.barycentric);
        }
    });
    return light;
}

SemiRegularMesh Painter::paint(SemiRegularMesh part, const TransformOptions& transform, double most,
                               unsigned threads) const {
    std::vector<Light> samples = sample(part.positions, threads);
    if (part.positions.size() > kManyVertices && double(part.positions.size()) > most / 4) {
        // As fine as images are, or nearly: no need of what lies between.
        part.colors.clear();
        for (const Light& light : samples) part.colors.push_back(to_srgb(light));
        return part;
    }
    // Loop's rule moves vertices on every level, whatever the details.
    const bool may_grow = predict_rule(transform.kind) != PredictRule::Loop;
    GrowingSurface surface(part, transform, threads);
    for (;;) {
        const std::size_t count = surface.positions().size();
        surface.add_level();
        const std::span<const Vec3> finer = surface.positions();
        const std::vector<Light> more = sample(finer.subspan(count), threads);
        samples.insert(samples.end(), more.begin(), more.end());
        const auto ends = ends_of(triangles_at_level(part.base, surface.level()), count, finer.size());
        part.colors.clear();
        for (const Light& light : filtered(samples, ends)) part.colors.push_back(to_srgb(light));
        if (!may_grow || double(finer.size()) > most) return part;
        const double edge = mean_edge(surface.positions(), ends), error = left_out(part.colors, samples, ends);
        if (edge <= kPixel || error <= (edge <= kShortEdge ? kNearlyShown : kShown)) return part;
        part.levels = surface.level();
        part.positions.assign(finer.begin(), finer.end());
        extend_fields(part, ends);
    }
}

}  // namespace mvw
