#include "codec/enc_closing.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "codec/enc_errors.h"
#include "codec/part_params.h"
#include "codec/tiles.h"

namespace mvw {

namespace {

constexpr double kHeadAndRow = 13;       // bytes, of a chunk in the file and in its index
constexpr double kBitsAtLeast = 9;       // a vertex, that a closing part takes
constexpr double kGoodEnough = 1.78e-4;  // RMS, 75 dB: while its base comes, the picture is at least as good
constexpr double kDecibel = 1.09;        // of 1.122: the step from wavelets to what follows them, ...
constexpr double kStepVisible = 1.4;     // ... if need be, where something was wrong
constexpr double kInvisible = 2.5e-5;    // RMS, 92 dB: what is better counts no more
constexpr double kVisible = 2e-3;        // largest distance, or ...
constexpr double kRough = 1e-4;          // ... RMS error, of surfaces that may take more bytes, ...
constexpr double kMostGrowthVisible = 4, kMostGrowth = 1.4;  // ... so many times more; and others
constexpr double kFinestError = 3e-6, kFinalError = 3e-5;    // RMS, that a closed file leaves at least, at most ...
constexpr double kFinalShare = 0.75;                         // ... and of what wavelets left
// dB in the mean of all beginnings that a closed file may lose: times the share by which it is shorter, or where
// something was wrong.
constexpr double kMostLost = 0.4, kMostLostVisible = 0.5;
constexpr double kFinerGain = 0.1;                              // dB in the mean, for a finer grid than the coarsest
constexpr unsigned kFewestBits = 9, kMostBits = 14;             // of the grid: coarser ones look rough
constexpr unsigned kMostTried = 3;                              // grids
constexpr std::uint32_t kVerticesOfTile = 60, kMostTiles = 16;  // so that one tile more is a small step, too
constexpr double kSharp = 0.87;                                 // cosine of 30 degrees
constexpr std::uint32_t kSamples = 100'000;

/// In coded units; edges between faces that meet at an angle are creases, so that their ends have no coarse steps.
std::optional<SemiRegularMesh> part_of(const EncoderInput& input) {
    SemiRegularMesh mesh;
    const Mesh& from = input.mesh();
    Result<BaseMesh> base = BaseMesh::create(static_cast<std::uint32_t>(from.positions.size()), from.faces);
    if (!base.ok()) return std::nullopt;
    mesh.base = std::move(*base);
    mesh.materials = from.materials;
    for (const Vec3& p : from.positions) mesh.positions.push_back(input.to_coded_units(p));
    const auto normal = [&](std::uint32_t f) {
        const Face& c = mesh.base.faces()[f];
        return normalized(
            cross(mesh.positions[c[1]] - mesh.positions[c[0]], mesh.positions[c[2]] - mesh.positions[c[0]]));
    };
    for (const BaseEdge& e : mesh.base.edges())
        mesh.creases.push_back(e.face[1] != kNone && dot(normal(e.face[0]), normal(e.face[1])) < kSharp);
    return mesh;
}

/// RMS error of the input with its vertices on a grid.
double error_on_grid(const EncoderInput& input, const SemiRegularMesh& mesh, unsigned bits, unsigned threads) {
    Mesh rounded;
    rounded.faces = input.mesh().faces;
    const double scale = std::ldexp(1.0, static_cast<int>(bits));
    for (const Vec3& p : mesh.positions)
        rounded.positions.push_back(input.to_model_units(
            {std::round(p.x * scale) / scale, std::round(p.y * scale) / scale, std::round(p.z * scale) / scale}));
    if (!measurable(rounded)) return 1;
    return input.reference().error_of(rounded, sampled(kSamples, threads)).rms;
}

/// A grid for the vertices, and the RMS error that it leaves.
struct RatedGrid {
    unsigned bits;
    double error;
    bool is_large_step;  // from the wavelets at their end
};

/// The coarsest grid that is good enough and some finer ones. At most the last is a large step, of no more than `most`
/// times the error. The first may be any.
std::vector<RatedGrid> grids_to_try(const EncoderInput& input, const SemiRegularMesh& mesh, double wavelets,
                                    double most, unsigned threads) {
    std::vector<RatedGrid> grids;
    for (unsigned bits = kFewestBits; bits <= kMostBits && grids.size() < kMostTried; ++bits) {
        const double error = error_on_grid(input, mesh, bits, threads);
        const bool is_large_step = !grids.empty() && error * kDecibel < wavelets;
        if (is_large_step && error * most < wavelets) break;
        if (!is_large_step && !grids.empty() && grids.back().error > kGoodEnough) grids.clear();
        grids.push_back({bits, error, is_large_step});
        if (is_large_step) break;
    }
    return grids;
}

double bytes_of(const PlannedChunk& chunk) {
    return kHeadAndRow + double(chunk.payload.size());
}

double bytes_of(std::span<const PlannedChunk> chunks) {
    double bytes = 0;
    for (const PlannedChunk& c : chunks) bytes += bytes_of(c);
    return bytes;
}

/// What the beginnings of a file are worth: the integral of PSNR over the logarithm of bytes.
class Worth {
 public:
    void add(double bytes, double rms) {
        if (at_ > 0) sum_ += psnr_ * std::log((at_ + bytes) / at_);
        if (at_ == 0) first_ = bytes;
        at_ += bytes;
        psnr_ = -20 * std::log10(std::max(rms, kInvisible));
    }
    [[nodiscard]] double first() const { return first_; }
    [[nodiscard]] double up_to(double bytes) const { return sum_ + psnr_ * std::log(std::max(bytes / at_, 1.0)); }

 private:
    double first_ = 0, at_ = 0, psnr_ = 0, sum_ = 0;
};

/// Weighs what a tile's planes gain by the surface that its vertices stand for: a few long triangles may be half of it.
void weigh_by_area(CodedPart& part, unsigned tiles) {
    const BaseMesh& base = part.mesh.base;
    const std::vector<Vec3>& at = part.mesh.positions;
    const Tiling tiling(base, tile_of_faces(base, tiles), tiles);
    std::vector<double> area(tiles, 0);  // of a third of each face at each vertex
    double whole = 0;
    for (const Face& f : base.faces()) {
        const double third = length(cross(at[f[1]] - at[f[0]], at[f[2]] - at[f[0]])) / 6;
        for (const std::uint32_t v : f) area[tiling.vertex[v].tile] += third;
        whole += 3 * third;
    }
    if (whole <= 0) return;
    for (CodedBlock& block : part.blocks) {
        const auto vertices = static_cast<double>(tiling.tiles[block.tile].vertices.size());
        for (double& gain : block.gain) gain *= area[block.tile] / whole * base.vertex_count() / vertices;
    }
}

Closing close_with(const EncoderInput& input, const SemiRegularMesh& mesh, const RatedGrid& grid,
                   const Opening& opening, const ClosingOptions& options) {
    PartPrecision precision;
    precision.colors = input.mesh().material_colors;
    precision.base_bits = grid.bits;
    precision.supersedes = true;
    precision.fast = options.fast;
    precision.error = std::clamp(kFinalShare * opening.whole.rms, kFinestError, kFinalError);
    precision.tiles =
        std::clamp(mesh.base.vertex_count() / kVerticesOfTile, 1u, std::min(kMostTiles, mesh.base.face_count()));
    Closing closing;
    std::vector<CodedPart> parts;
    parts.push_back(code_part(mesh, TransformOptions{}, precision, {}, options.threads));
    weigh_by_area(parts[0], precision.tiles);
    closing.info = {0,
                    mesh.base.vertex_count(),
                    mesh.base.edge_count(),
                    mesh.base.face_count(),
                    static_cast<std::uint16_t>(precision.tiles),
                    0,
                    true};
    closing.layers = std::max(opening.layers, layers_of(parts));
    OrderOptions order;
    order.layers = closing.layers;
    order.area_share = {1};
    order.least_bytes = 1;  // each plane of a tile by itself: together they would be a large step
    closing.chunks = order_chunks(parts, order);
    closing.base_error = grid.error;
    const auto near = [&](const PlannedChunk& c) { return c.error <= grid.error * kDecibel; };
    const auto last = std::ranges::find_if(opening.plan, near);
    closing.opening_chunks = static_cast<std::size_t>(last - opening.plan.begin()) + (last != opening.plan.end());
    return closing;
}

/// Where wavelets end and the closing part begins.
class Switch {
 public:
    Switch(const EncoderInput& input, const Opening& opening, double base_error, unsigned threads)
        : input_(input), opening_(opening), base_error_(base_error), threads_(threads) {}

    /// Keeps the shortest beginning of the opening that is about as good as the closing part's base, and no better:
    /// what follows would be worse. may_cut: it may end inside a chunk, so that the step to the base is a small one.
    /// False where the opening's bases alone are better.
    [[nodiscard]] bool set(Closing& closing, bool may_cut) const {
        const auto is_base = [](const PlannedChunk& c) { return c.id.channel == Channel::Base; };
        std::size_t low = static_cast<std::size_t>(std::ranges::count_if(opening_.plan, is_base));
        std::size_t high = opening_.plan.size();  // chunks that are enough; of low ones it is not known, then too few
        const double least = error_of(low);
        if (is_better(least)) return false;
        if (is_good(least)) high = low;
        while (high > low + 1) {
            const std::size_t middle = low + (high - low) / 2;
            (is_good(error_of(middle)) ? high : low) = middle;
        }
        closing.opening_chunks = high;
        if (high == low || !is_better(error_of(high))) return true;
        closing.opening_chunks = low;
        if (may_cut) closing.beginning = beginning_of(low);
        return true;
    }

 private:
    static constexpr double kNoFall = 1.005;
    [[nodiscard]] bool is_good(double rms) const { return rms <= base_error_ * kDecibel; }
    [[nodiscard]] bool is_better(double rms) const { return rms < base_error_ * kNoFall; }

    /// RMS error of the first chunks, and of one more.
    [[nodiscard]] double error_of(std::size_t chunks, const PlannedChunk* last = nullptr) const {
        PlanDecoder decoder(opening_.file);
        decoder.feed(std::span(opening_.plan).first(chunks));
        if (last) decoder.feed(*last);
        const std::optional<SurfaceError> error = decoder.error(input_, sampled(kSamples, threads_));
        return error ? error->rms : INFINITY;
    }

    /// As much of a chunk as makes the first ones good enough; nothing where one byte more or less is too large a step.
    [[nodiscard]] std::optional<PlannedChunk> beginning_of(std::size_t chunk) const {
        PlannedChunk beginning = opening_.plan[chunk];
        if (beginning.id.channel != Channel::Geometry) return std::nullopt;
        const Bytes payload = beginning.payload;
        ByteReader in(payload);
        GeometryFront front = read_geometry_front(in);
        front.beginning = true;
        const ByteSpan planes = in.bytes(in.remaining());
        for (std::size_t low = front.least_bytes, high = planes.size(); high > low + 1;) {
            const std::size_t middle = low + (high - low) / 2;
            beginning.payload = with_front(front, ByteReader(planes.first(middle)));
            beginning.error = error_of(chunk, &beginning);
            if (!is_good(beginning.error))
                low = middle;
            else if (is_better(beginning.error))
                high = middle;
            else
                return beginning;
        }
        return std::nullopt;
    }

    const EncoderInput& input_;
    const Opening& opening_;
    const double base_error_;
    const unsigned threads_;
};

}  // namespace

std::optional<Closing> close(const EncoderInput& input, const Opening& opening, const ClosingOptions& options) {
    const double wavelets = bytes_of(opening.plan);
    const bool visible = opening.whole.max > kVisible || opening.whole.rms > kRough;
    const double growth = visible ? kMostGrowthVisible : opening.whole.rms > kInvisible ? kMostGrowth : 1;
    const double most = wavelets * growth;
    if (double(input.mesh().positions.size()) * kBitsAtLeast / 8 > most) return std::nullopt;
    const std::optional<SemiRegularMesh> mesh = part_of(input);
    if (!mesh) return std::nullopt;

    Worth alone;
    for (const PlannedChunk& c : opening.plan) alone.add(bytes_of(c), c.error);
    std::optional<Closing> best;
    double gain = 0;  // dB in the mean
    const double step = visible ? kStepVisible : kDecibel;
    for (const RatedGrid& grid : grids_to_try(input, *mesh, opening.whole.rms, step, options.threads)) {
        if (best && grid.is_large_step) break;  // only where it must be
        Closing closing = close_with(input, *mesh, grid, opening, options);
        const auto stays = std::span(opening.plan).first(closing.opening_chunks);
        const double bytes = bytes_of(stays) + bytes_of(closing.chunks), end = std::max(bytes, wavelets);
        Worth closed;
        for (const PlannedChunk& c : stays) closed.add(bytes_of(c), c.error);
        for (const PlannedChunk& c : closing.chunks) closed.add(bytes_of(c), std::min(std::sqrt(c.error), grid.error));
        const double gain_here = (closed.up_to(end) - alone.up_to(end)) / std::log(end / alone.first());
        const double most_lost = visible ? kMostLostVisible : kMostLost * wavelets / bytes;
        if (bytes > most || gain_here < -most_lost) continue;
        // Finer grids come later in the file, which is longer then.
        if (best && (gain_here < gain + kFinerGain || (!visible && bytes > wavelets))) continue;
        gain = gain_here;
        best = std::move(closing);
    }
    if (!best) return best;
    if (!Switch(input, opening, best->base_error, options.threads).set(*best, !options.fast)) return std::nullopt;
    double bytes = bytes_of(std::span(opening.plan).first(best->opening_chunks)) + bytes_of(best->chunks);
    if (best->beginning) bytes += bytes_of(*best->beginning);
    return bytes <= most ? std::move(best) : std::nullopt;
}

}  // namespace mvw
