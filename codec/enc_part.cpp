#include "codec/enc_part.h"

#include <algorithm>
#include <set>

#include "codec/enc_attributes.h"
#include "codec/enc_lattice.h"
#include "codec/tiles.h"
#include "codec/transform/integer.h"

namespace mvw {

namespace {

constexpr float kReconstruction = 0.5f;  // 0.2 to 0.4 dB better than 0.4 on real scans

/// Tangential steps over normal ones, of the finest level, the next coarser one and so on: the finer a level, the less
/// it matters where within the surface its vertices lie.
double across_of(unsigned levels_above) {
    constexpr std::array<double, 4> kAcross{7, 5, 4, 3};
    return kAcross[std::min<std::size_t>(levels_above, kAcross.size() - 1)];
}

/// Likewise of plain triangles, of which some are small or have sharp edges: they must not fold.
constexpr double kPlainAcross = 2.2;

/// Steps whose errors weigh the same on every level; plane 0 leaves about `error`.
void choose_steps(PartParams& params, const TransformOptions& transform, unsigned levels,
                  const PartPrecision& precision) {
    const unsigned detailed = levels - precision.bare_levels;
    const std::vector<LevelGain> gains = synthesis_gains(transform, detailed);
    const double move = precision.error * 1.3;  // of vertices by one step; measured with dead zone and tangents
    for (unsigned l = 0; l <= levels; ++l) {
        const unsigned level = std::min(l, detailed);
        const double across = precision.supersedes     ? kPlainAcross
                              : transform.local_frames ? across_of(detailed - level)
                                                       : 1;
        const double step = move / gains[level].normal;
        params.steps.push_back(step_to_code(std::min(step, 1.0)));
        params.across.push_back(step_to_code(std::min(step * across, 1.0)));
    }
}

/// The coarse positions that analysis leaves, not samples of the surface: what the base carries.
std::vector<Vec3> coarse_of(const SemiRegularMesh& mesh, const TransformOptions& transform, unsigned threads) {
    if (mesh.levels == 0) return mesh.positions;
    std::vector<Vec3f> in(mesh.positions.size()), out(mesh.positions.size());
    std::transform(mesh.positions.begin(), mesh.positions.end(), in.begin(), to_float);
    PatchTransform(mesh.base, mesh.levels, transform, mesh.creases, threads).analyze(in, out);
    std::vector<Vec3> coarse(mesh.base.vertex_count());
    std::transform(out.begin(), out.begin() + std::ptrdiff_t(coarse.size()), coarse.begin(), to_double);
    return coarse;
}

std::vector<Vec3f> coefficients_of(const SemiRegularMesh& mesh, const PartUnits& units, const PartParams& params,
                                   unsigned threads) {
    std::vector<Vec3f> positions(mesh.positions.size()), out(mesh.positions.size());
    std::transform(mesh.positions.begin(), mesh.positions.end(), positions.begin(), to_float);
    PatchTransform(mesh.base, mesh.levels, params.transform, mesh.creases, threads).analyze(positions, out);
    for (std::uint32_t v = 0; v < mesh.base.vertex_count(); ++v)
        out[v] = units.frame(v).to_local(out[v] - units.origin(v));
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
    const PartUnits units(part.mesh.base, part.mesh.creases, part.mesh.materials, part.base.grid, part.params);
    const std::vector<Vec3f> coefficients = coefficients_of(part.mesh, units, part.params, threads);
    part.tangential_share = tangential_share(coefficients, part.mesh.base);
    const auto vertices = static_cast<double>(part.mesh.positions.size());
    part.rounding = code_blocks(part, Channel::Geometry, precision, [&](const BlockShape& shape, unsigned level) {
        // A tangential move slides along the surface: it counts as its coarser step says, so a step as much as any.
        const double move = double{part.params.step(level)} * gains[level].normal;
        ScaledBlock scaled;
        scaled.unit.assign(3, move * move / vertices);
        scaled.values.reserve(shape.size() * 3);
        for (const std::uint32_t v : shape.indices()) {
            const Vec3f& c = coefficients[v];
            const Vec3f step = units.steps(level, v);
            scaled.values.insert(scaled.values.end(), {c.x / step.x, c.y / step.y, c.z / step.z});
        }
        return scaled;
    });
}

}  // namespace

unsigned components_of(const CodedPart& part, Channel channel) {
    const auto found = std::ranges::find(part.attributes, channel, &AttributeParams::channel);
    return found != part.attributes.end() ? found->components() : 3;
}

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

namespace {

std::vector<IntegerPoint> integers_of(const std::vector<Vec3>& points, unsigned bits) {
    std::vector<IntegerPoint> out(points.size());
    for (std::size_t v = 0; v < out.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k)
            out[v][k] = static_cast<std::int32_t>(std::lround(std::ldexp(points[v][k], static_cast<int>(bits))));
    return out;
}

/// Integers in units of the grid; plane 0 is the unit, so all planes are exact.
void code_integers(CodedPart& part, const PartPrecision& precision) {
    const SemiRegularMesh& mesh = part.mesh;
    std::vector<IntegerPoint> details = integers_of(mesh.positions, precision.lossless);
    analyze_integers(mesh.base, mesh.levels, mesh.creases, details);
    for (std::uint32_t v = 0; v < mesh.base.vertex_count(); ++v) details[v] = {0, 0, 0};  // the base has them
    TransformOptions butterfly;
    butterfly.kind = TransformKind::ButterflyLazy;
    const std::vector<LevelGain> gains = synthesis_gains(butterfly, mesh.levels);
    const auto vertices = static_cast<double>(mesh.positions.size());
    part.rounding = code_blocks(part, Channel::Geometry, precision, [&](const BlockShape& shape, unsigned level) {
        const double move = part.params.lattice.unit() * gains[level].normal;
        ScaledBlock scaled;
        scaled.unit.assign(3, move * move / vertices);
        for (const std::uint32_t v : shape.indices())
            for (const std::int32_t x : details[v]) scaled.values.push_back(static_cast<float>(x));
        return scaled;
    });
}

/// Those of materials that the part has.
std::vector<MaterialColor> colors_of(const SemiRegularMesh& mesh, std::vector<MaterialColor> colors) {
    const std::set<std::uint32_t> labels(mesh.materials.begin(), mesh.materials.end());
    std::erase_if(colors, [&](const MaterialColor& c) {
        return mesh.materials.empty() ? c.label != 0 : !labels.contains(c.label);
    });
    return colors;
}

CodedPart code_lossless(const SemiRegularMesh& mesh, const PartPrecision& precision, unsigned threads) {
    CodedPart part;
    part.params.fast = precision.fast;
    part.params.lossless = true;
    part.params.colors = colors_of(mesh, precision.colors);
    part.params.lattice.bits = static_cast<std::uint8_t>(precision.lossless);
    part.params.reconstruction = 128;
    std::vector<IntegerPoint> grid = integers_of(mesh.positions, precision.lossless);
    grid.resize(mesh.base.vertex_count());
    part.base = code_base(mesh.base, grid, part.params.lattice.bits, false);
    part.mesh = renumber(mesh, part.base);
    if (mesh.levels > 0) {
        part.params.steps.assign(mesh.levels + 1, step_to_code(part.params.lattice.unit()));
        part.params.across = part.params.steps;
        part.first_tiled_level = precision.tiles > 1 ? precision.first_tiled_level : 0;
        code_integers(part, precision);
    }
    code_attributes(precision, threads, part);
    return part;
}

}  // namespace

namespace {

CodedPart begin_part(const SemiRegularMesh& mesh, const TransformOptions& transform, const PartPrecision& precision) {
    CodedPart part;
    part.params.transform = transform;
    part.params.fast = precision.fast;
    part.params.colors = colors_of(mesh, precision.colors);
    part.params.reconstruction = static_cast<std::uint8_t>(std::lround(kReconstruction * 256));
    return part;
}

/// Once the part's mesh and base are there.
void add_planes(const PartPrecision& precision, unsigned threads, CodedPart& part) {
    const unsigned levels = part.mesh.levels;
    const std::vector<LevelGain> gains = synthesis_gains(part.params.transform, levels);
    choose_steps(part.params, part.params.transform, levels, precision);
    part.first_tiled_level = precision.tiles > 1 ? precision.first_tiled_level : 0;
    code_geometry(part, precision, gains, threads);
}

}  // namespace

CodedPart code_part(const SemiRegularMesh& mesh, const TransformOptions& transform, const PartPrecision& precision,
                    const Rounded& base, unsigned threads) {
    if (precision.lossless > 0) return code_lossless(mesh, precision, threads);
    CodedPart part = begin_part(mesh, transform, precision);
    const Rounded own = base.grid.empty() ? round_to_lattice(coarse_of(mesh, transform, threads), mesh.base.faces(),
                                                             precision.base_bits)
                                          : base;
    part.params.lattice = own.lattice;
    part.base = code_base(mesh.base, own.grid, own.lattice.bits, precision.alone);
    part.mesh = renumber(mesh, part.base);
    if (mesh.levels > 0 || precision.supersedes) add_planes(precision, threads, part);
    code_attributes(precision, threads, part);
    return part;
}

CodedPart code_planes(const SemiRegularMesh& mesh, const PartPrecision& precision, const Rounded& base,
                      unsigned threads) {
    CodedPart part = begin_part(mesh, {}, precision);
    part.params.lattice = base.lattice;
    part.base.mesh = mesh.base;
    part.base.grid = base.grid;
    part.mesh = mesh;
    add_planes(precision, threads, part);
    return part;
}

}  // namespace mvw
