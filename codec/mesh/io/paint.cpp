#include "codec/mesh/io/paint.h"

#include <algorithm>
#include <cmath>

#include "codec/mesh/srgb.h"

namespace mvw {

namespace {

class PaintedSurface : public Paintwork {
 public:
    PaintedSurface(Mesh surface, PaintedFaces painted) : surface_(std::move(surface)), painted_(std::move(painted)) {}

    [[nodiscard]] const Mesh& surface() const override { return surface_; }
    [[nodiscard]] std::array<double, 4> at(std::uint32_t face, const std::array<double, 3>& weights) const override {
        double u = 0, v = 0;
        std::array<double, 4> tint{1, 1, 1, 1};
        if (!painted_.tints.empty()) tint = {};
        for (std::size_t c = 0; c < 3; ++c) {
            if (weights[c] == 0) continue;  // what is not finite stays away from the other corners
            const auto& place = painted_.coordinates[std::size_t{3} * face + c];
            u += weights[c] * static_cast<double>(place[0]);
            v += weights[c] * static_cast<double>(place[1]);
            if (painted_.tints.empty()) continue;
            const auto& of_corner = painted_.tints[surface_.faces[face][c]];
            for (std::size_t k = 0; k < 4; ++k) tint[k] += weights[c] * static_cast<double>(of_corner[k]);
        }
        std::array<double, 4> out = painted_.paints[painted_.paint_of[face]].at(u, v);
        for (std::size_t k = 0; k < 4; ++k) out[k] *= tint[k];
        return out;
    }

 private:
    const Mesh surface_;
    const PaintedFaces painted_;
};

}  // namespace

std::array<double, 4> Paint::at(double u, double v) const {
    std::array<double, 4> out = color;
    if (texture && std::isfinite(u) && std::isfinite(v)) {
        const auto row = [&](const std::array<double, 3>& r) { return r[0] * u + r[1] * v + r[2]; };
        const std::array<double, 4> texel = texture->at(row(place[0]), row(place[1]), across, down);
        for (std::size_t k = 0; k < 4; ++k) out[k] *= texel[k];
    }
    if (opaque) out[3] = 1;
    return out;
}

bool are_plain(std::span<const Paint> paints) {
    return std::ranges::all_of(paints, [&](const Paint& p) {
        const std::array<double, 4>& c = p.color;
        return !p.texture && c == paints.front().color && c[0] == c[1] && c[1] == c[2] && c[3] == 1;
    });
}

std::unique_ptr<const Paintwork> make_paintwork(Mesh surface, PaintedFaces painted) {
    return std::make_unique<PaintedSurface>(std::move(surface), std::move(painted));
}

std::vector<Rgba8> vertex_colors(const Paintwork& paintwork) {
    const Mesh& surface = paintwork.surface();
    std::vector<std::array<double, 4>> sums(surface.positions.size());
    std::vector<std::uint32_t> corners(surface.positions.size(), 0);
    for (std::uint32_t f = 0; f < surface.faces.size(); ++f)
        for (std::size_t c = 0; c < 3; ++c) {
            std::array<double, 3> at{};
            at[c] = 1;
            const std::array<double, 4> color = paintwork.at(f, at);
            const std::uint32_t v = surface.faces[f][c];
            for (std::size_t k = 0; k < 4; ++k) sums[v][k] += color[k];
            ++corners[v];
        }
    std::vector<Rgba8> colors(sums.size());
    for (std::size_t v = 0; v < colors.size(); ++v) {
        if (corners[v] == 0) continue;
        for (double& x : sums[v]) x /= corners[v];
        colors[v] = to_srgb(sums[v]);
    }
    return colors;
}

}  // namespace mvw
