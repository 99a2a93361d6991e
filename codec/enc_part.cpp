#include "codec/enc_part.h"

#include <algorithm>

#include "codec/enc_color.h"
#include "codec/tiles.h"

namespace mvw {

namespace {

constexpr float kReconstruction = 0.5f;  // 0.2 to 0.4 dB better than 0.4 on real scans

/// Tangential steps over normal ones, of the finest level, the next coarser one and so on: the finer a level, the less
/// it matters where within the surface its vertices lie.
double across_of(unsigned levels_above) {
    constexpr std::array<double, 4> kAcross{7, 5, 4, 3};
    return kAcross[std::min<std::size_t>(levels_above, kAcross.size() - 1)];
}

/// Steps whose errors weigh the same on every level; plane 0 leaves about `error`. Level 0 is in model axes, of which a
/// third is normal.
void choose_steps(PartParams& params, const TransformOptions& transform, unsigned levels, double error,
                  const std::vector<LevelGain>& gains) {
    const double move = error * 1.3;  // of the finest vertices by one step; measured with dead zone and tangents
    const double across_base = across_of(levels);
    for (unsigned level = 0; level <= levels; ++level) {
        const double axes = level == 0 ? std::sqrt(3 / (1 + 2 / (across_base * across_base))) : 1;
        const double across = level == 0 || !transform.local_frames ? 1 : across_of(levels - level);
        const double step = move * axes / gains[level].normal;
        params.steps.push_back(step_to_code(std::min(step, 1.0)));
        params.across.push_back(step_to_code(std::min(step * across, 1.0)));
    }
}

/// Weights of a coefficient's squared error, by component, in the part's mean squared surface error: tangential moves
/// slide along the surface, they count as their coarser step says.
std::array<double, 3> error_weights(const PartParams& params, const LevelGain& gain, unsigned level, double vertices) {
    const double n = gain.normal * gain.normal / vertices;
    const double ratio = double{params.step(level)} / double{params.step_across(level)};
    if (level > 0) return {n, n * ratio * ratio, n * ratio * ratio};
    const double across = across_of(static_cast<unsigned>(params.steps.size()) - 1);
    const double mean = n * (1 + 2 / (across * across)) / 3;
    return {mean, mean, mean};
}

std::vector<Vec3f> coefficients_of(const SemiRegularMesh& mesh, const CodedBase& base, const PartParams& params,
                                   unsigned threads) {
    std::vector<Vec3f> positions(mesh.positions.size()), out(mesh.positions.size());
    std::transform(mesh.positions.begin(), mesh.positions.end(), positions.begin(), to_float);
    PatchTransform(mesh.base, mesh.levels, params.transform, mesh.creases, threads).analyze(positions, out);
    const auto grid = static_cast<float>(params.grid());
    for (std::size_t v = 0; v < base.grid.size(); ++v) {
        const auto& g = base.grid[v];
        out[v] -= Vec3f{static_cast<float>(g[0]), static_cast<float>(g[1]), static_cast<float>(g[2])} * grid;
    }
    return out;
}

double tangential_share(const std::vector<Vec3f>& coefficients, const BaseMesh& base) {
    double all = 0, tangential = 0;
    for (std::size_t v = vertices_at_level(base, 1); v < coefficients.size(); ++v) {
        const Vec3 d = to_double(coefficients[v]);
        all += squared_length(d);
        tangential += d.y * d.y + d.z * d.z;
    }
    return all > 0 ? tangential / all : 0;
}

CodedBlock code_block(const CodedPart& part, const BlockShape& shape, const ScaledBlock& scaled,
                      std::span<const std::uint32_t> parent, double& left) {
    const std::size_t components = scaled.unit.size();
    CodedBlock block;
    block.planes = encode_block(shape, static_cast<unsigned>(components), scaled.values, parent,
                                part.params.reconstruction_point());
    for (std::size_t k = 0; k < scaled.values.size(); ++k)
        left += double{scaled.values[k]} * scaled.values[k] * scaled.unit[k % components];
    for (const EncodedPlane& plane : block.planes.planes) {
        double gain = 0;
        for (std::size_t c = 0; c < components; ++c) gain += plane.error_reduction[c] * scaled.unit[c];
        block.gain.push_back(gain);
        left -= gain;
    }
    return block;
}

void code_geometry(CodedPart& part, const PartPrecision& precision, const std::vector<LevelGain>& gains,
                   unsigned threads) {
    const std::vector<Vec3f> coefficients = coefficients_of(part.mesh, part.base, part.params, threads);
    part.tangential_share = tangential_share(coefficients, part.mesh.base);
    const auto vertices = static_cast<double>(part.mesh.positions.size());
    part.rounding = code_blocks(part, Channel::Geometry, precision, [&](const BlockShape& shape, unsigned level) {
        const float step = part.params.step(level), across = part.params.step_across(level);
        const std::array<double, 3> weight = error_weights(part.params, gains[level], level, vertices);
        ScaledBlock scaled;
        scaled.unit = {double{step} * step * weight[0], double{across} * across * weight[1],
                       double{across} * across * weight[2]};
        scaled.values.reserve(shape.size() * 3);
        for (const std::uint32_t v : shape.indices()) {
            const Vec3f& c = coefficients[v];
            scaled.values.insert(scaled.values.end(), {c.x / step, c.y / across, c.z / across});
        }
        return scaled;
    });
}

}  // namespace

bool has_parents(const CodedPart& part, unsigned level) {
    return !part.params.fast && level >= 2 && (level != part.first_tiled_level || part.first_tiled_level == 0);
}

double code_blocks(CodedPart& part, Channel channel, const PartPrecision& precision,
                   const std::function<ScaledBlock(const BlockShape&, unsigned level)>& scale) {
    const BaseMesh& base = part.mesh.base;
    const Tiling tiled(base, tile_of_faces(base, precision.tiles), precision.tiles);
    const Tiling whole(base, std::vector<std::uint16_t>(base.face_count(), 0), 1);
    double left = 0;
    for (std::uint32_t tile = 0; tile < precision.tiles; ++tile)
        for (unsigned level = tile == 0 ? 0 : part.first_tiled_level; level <= part.mesh.levels; ++level) {
            const BlockShape shape(base, level >= part.first_tiled_level ? tiled : whole, tile, level);
            std::span<const std::uint32_t> parent;
            if (has_parents(part, level)) parent = part.blocks.back().planes.entries;
            CodedBlock block = code_block(part, shape, scale(shape, level), parent, left);
            block.channel = channel;
            block.tile = static_cast<std::uint16_t>(tile);
            block.level = static_cast<std::uint8_t>(level);
            part.blocks.push_back(std::move(block));
        }
    return left;
}

CodedPart code_part(const SemiRegularMesh& mesh, const TransformOptions& transform, const PartPrecision& precision,
                    unsigned threads) {
    CodedPart part;
    part.params.transform = transform;
    part.params.fast = precision.fast;
    part.params.base_bits = static_cast<std::uint8_t>(precision.base_bits);
    part.params.reconstruction = static_cast<std::uint8_t>(std::lround(kReconstruction * 256));
    if (mesh.levels == 0) {
        part.base = code_base(mesh.base, mesh.positions, precision.base_bits);
        part.mesh = renumber(mesh, part.base);
        code_colors(precision, threads, part);
        return part;
    }
    // The base carries the coarse positions that analysis leaves, not samples of the surface.
    const std::vector<LevelGain> gains = synthesis_gains(transform, mesh.levels);
    choose_steps(part.params, transform, mesh.levels, precision.error, gains);
    const auto coarse = [&] {
        std::vector<Vec3f> in(mesh.positions.size()), out(mesh.positions.size());
        std::transform(mesh.positions.begin(), mesh.positions.end(), in.begin(), to_float);
        PatchTransform(mesh.base, mesh.levels, transform, mesh.creases, threads).analyze(in, out);
        std::vector<Vec3> points(mesh.base.vertex_count());
        std::transform(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(points.size()), points.begin(),
                       to_double);
        return points;
    }();
    part.base = code_base(mesh.base, coarse, precision.base_bits);
    part.mesh = renumber(mesh, part.base);

    part.first_tiled_level = precision.tiles > 1 ? precision.first_tiled_level : 0;
    code_geometry(part, precision, gains, threads);
    code_colors(precision, threads, part);
    return part;
}

}  // namespace mvw
