#include "codec/enc_remeshed.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "codec/decoder.h"
#include "codec/enc_adapt.h"
#include "codec/enc_closing.h"
#include "codec/enc_end.h"
#include "codec/enc_errors.h"
#include "codec/enc_least_bytes.h"
#include "codec/enc_measured_order.h"
#include "codec/enc_original.h"
#include "codec/enc_paint.h"
#include "codec/mesh/material_colors.h"
#include "codec/remesh/parallel.h"

namespace mvw {

namespace {

constexpr std::uint32_t kSamplesForRemeshing = 10'000, kStrideForRemeshing = 4;
constexpr double kRoundingShare = 0.4;      // of the remeshing error may be added by rounding
constexpr double kFinestRounding = 4e-6;    // where remeshing leaves nothing
constexpr double kFinestAlone = 2e-5;       // of parts that Draco codes alone
constexpr double kVerticesOfTile = 65'536;  // a tile has at least so many, so that its chunks are worth their heads
constexpr unsigned kMostTiles = 64;
constexpr std::uint64_t kLeastOfTile = 16'384;  // coarser levels, where tiles would have fewer vertices, are not tiled
constexpr double kLongestLeastBytes = 8192;
constexpr std::size_t kPlanesOfPacked = 2;  // of a chunk of the fast profile, whose every coefficient takes a byte
constexpr double kCellsOfEdge = 8;          // of the grid that bases are snapped to, for each of a base's edges
constexpr std::uint32_t kSamplesForChoice = 16'000, kVertexStride = 16;
constexpr unsigned kBudgets = 5;                    // sizes at which files are compared, ...
constexpr double kLeastBudget = 1024;               // ... none below, ...
constexpr double kLeastBits = 0.2, kMostBits = 3;   // ... from and to, for each of the input's vertices, ...
constexpr double kLeastRange = 8;                   // ... at least so far apart: small models are wanted whole
constexpr unsigned kBudgetsOfScore = 4;             // of them: at the last one drafts of fewer levels are at their end
constexpr std::size_t kMostSideBySide = 1'200'000;  // vertices of drafts that are made at the same time
constexpr double kMostLost = 0.7;                   // dB of the whole file that better beginnings may cost, ...
constexpr double kEnough = 84;                      // ... unless it stays above this
constexpr double kNothing = 35;                     // PSNR that a beginning too short for any surface counts as
constexpr double kExact = 150;                      // and the most that any does
constexpr double kMostOverhead = 0.045;             // of the file: heads, header, index
constexpr double kMostPainted = 1'048'576;          // vertices that a file may come to by levels for colours alone

double area(const Mesh& mesh) {
    double sum = 0;
    for (const Face& f : mesh.faces)
        sum += length(cross(mesh.positions[f[1]] - mesh.positions[f[0]], mesh.positions[f[2]] - mesh.positions[f[0]]));
    return sum / 2;
}

void lay_tiles(const SemiRegularMesh& part, const EncodeOptions& options, PartPrecision& precision) {
    const double wanted_tiles =
        options.tile_count > 0
            ? options.tile_count
            : std::min<double>(std::round(double(part.positions.size()) / kVerticesOfTile), kMostTiles);
    precision.tiles =
        static_cast<unsigned>(std::clamp(wanted_tiles, 1.0, double(std::min(part.base.face_count(), 65'535u))));
    const auto vertices_of_tile = [&](unsigned level) { return vertices_at_level(part.base, level) / precision.tiles; };
    precision.first_tiled_level = 1;
    while (precision.first_tiled_level < part.levels && vertices_of_tile(precision.first_tiled_level) < kLeastOfTile)
        ++precision.first_tiled_level;
}

PartPrecision precision_of(const SemiRegularMesh& part, PartOrigin origin, const EncodeOptions& options,
                           double remesh_error) {
    PartPrecision precision;
    precision.fast = options.profile == Profile::Fast;
    precision.lossless = options.lossless;
    precision.field_error = options.field_error;
    // What remeshing leaves of the wanted error, else a share of what it left.
    const double t = options.target_error, r = remesh_error;
    precision.error = std::max(t > r * 1.1 ? 0.9 * std::sqrt(t * t - r * r) : r * kRoundingShare, kFinestRounding);
    precision.alone = part.levels == 0;
    if (origin == PartOrigin::Alone || origin == PartOrigin::Facets) {
        // A step s of the grid leaves s / sqrt(12) along the normal. Finer than 14 bits only where it was asked for.
        if (t <= 0) precision.error = std::max(precision.error, kFinestAlone);
        precision.base_bits =
            static_cast<unsigned>(std::clamp(std::ceil(-std::log2(precision.error * 3.4)), 10.0, 20.0));
    }
    if (origin != PartOrigin::Alone) lay_tiles(part, options, precision);
    return precision;
}

PartInfo info_of(const SemiRegularMesh& mesh, const PartPrecision& precision) {
    return {static_cast<std::uint8_t>(mesh.levels),
            mesh.base.vertex_count(),
            mesh.base.edge_count(),
            mesh.base.face_count(),
            static_cast<std::uint16_t>(precision.tiles),
            static_cast<std::uint8_t>(precision.tiles > 1 ? precision.first_tiled_level : 0)};
}

/// Everything about the parts that the chunks' order needs.
struct CodedModel {
    FileHeader header;
    std::vector<CodedPart> parts;
    OrderOptions order;
};

/// A file keeps s as a float: the encoder has to transform with that one.
TransformOptions as_stored(TransformOptions transform) {
    if (transform.s != TransformOptions{}.s) transform.s = static_cast<double>(static_cast<float>(transform.s));
    return transform;
}

/// What is to be coded, and how finely each part.
struct Source {
    EncoderInput& input;
    EncodeOptions options;
    std::vector<SemiRegularMesh> parts;                    // in coded units
    std::vector<PartOrigin> origins;                       // of each part
    std::vector<std::unique_ptr<Adaptation>> adaptations;  // none of parts that are coded as they are
    std::vector<PartPrecision> precision;
    double alone_area_share = 0, facets_area_share = 0;
};

/// Bits of a grid whose cells are a small part of a base edge.
unsigned bits_of_snap(const SemiRegularMesh& mesh) {
    double sum = 0;
    for (const BaseEdge& e : mesh.base.edges()) sum += length(mesh.positions[e.v[0]] - mesh.positions[e.v[1]]);
    const double mean = sum / double(mesh.base.edge_count());
    return static_cast<unsigned>(std::clamp(std::round(std::log2(kCellsOfEdge / mean)), 4.0, 12.0));
}

/// painter: null, or gives parts that have details their colours and levels for these.
void code_parts(const Source& source, const BaseGrid& grid, const Painter* painter, unsigned threads,
                CodedModel& model) {
    model.parts.clear();
    const TransformOptions transform = as_stored(source.options.transform);
    double vertices = 0;
    for (const SemiRegularMesh& part : source.parts) vertices += double(part.positions.size());
    for (std::size_t p = 0; p < source.parts.size(); ++p) {
        PartPrecision precision = source.precision[p];
        precision.colors = source.input.mesh().material_colors;
        Adaptation::Snapped snapped{source.parts[p], {}};
        if (grid.snapped && source.adaptations[p]) {
            precision.base_bits = bits_of_snap(snapped.mesh) + grid.finer_bits;
            snapped = source.adaptations[p]->snap(precision.base_bits, threads);
        }
        SemiRegularMesh& mesh = snapped.mesh;
        const bool is_flat = all_have_colors(precision.colors, mesh.materials);
        if (is_flat) mesh.colors.clear();
        if (painter && mesh.levels > 0 && !is_flat) {
            // Without details the next level of a recognised mesh would not be flat between its vertices.
            const bool may_grow =
                source.options.levels < 0 && source.options.color_levels && source.origins[p] != PartOrigin::Recognized;
            const double share = double(mesh.positions.size()) / vertices;
            mesh = painter->paint(std::move(mesh), transform, may_grow ? kMostPainted * share : 0, threads);
            precision.bare_levels = mesh.levels - source.parts[p].levels;
            lay_tiles(mesh, source.options, precision);
            model.header.parts[p] = info_of(mesh, precision);
        }
        model.parts.push_back(code_part(mesh, transform, precision, snapped.base, threads));
    }
    model.order.layers = layers_of(model.parts);
    model.header.layers = static_cast<std::uint8_t>(model.order.layers);
}

/// Moves what the remesher made to where it costs less.
Source adapt(EncoderInput& input, RemeshResult remeshed, const EncodeOptions& options) {
    Source source{input, options, std::move(remeshed.parts), std::move(remeshed.origins),
                  {},    {},      remeshed.alone_area_share, remeshed.facets_area_share};
    source.adaptations.resize(source.parts.size());
    for (std::uint32_t p = 0; p < source.parts.size(); ++p) {
        SemiRegularMesh& mesh = source.parts[p];
        for (Vec3& x : mesh.positions) x = input.to_coded_units(x);
        if (options.progress) options.progress("slide", double(p) / double(source.parts.size()));
        if (options.lossless > 0 || !options.transform.local_frames) continue;  // adapting asks for normals
        if (source.origins[p] != PartOrigin::Remeshed) continue;
        source.adaptations[p] = std::make_unique<Adaptation>(input.part(remeshed, p), as_stored(options.transform),
                                                             options.threads, std::move(mesh));
        source.adaptations[p]->slide(options.threads);
        mesh = source.adaptations[p]->mesh();
    }
    return source;
}

void describe(Source& source, CodedModel& model) {
    model.header = source.input.header();
    Mesh finest = finest_mesh(source.parts);
    for (Vec3& p : finest.positions) p = source.input.to_model_units(p);
    const double remesh_error =
        source.input.reference()
            .error_of(finest, {kSamplesForRemeshing, source.options.threads, kStrideForRemeshing})
            .rms;
    double whole = 0;
    for (std::size_t p = 0; p < source.parts.size(); ++p) {
        const SemiRegularMesh& mesh = source.parts[p];
        model.order.area_share.push_back(area(finest_mesh(std::span(&mesh, 1))));
        whole += model.order.area_share.back();
        source.precision.push_back(precision_of(mesh, source.origins[p], source.options, remesh_error));
        model.header.parts.push_back(info_of(mesh, source.precision.back()));
    }
    for (double& share : model.order.area_share) share = whole > 0 ? share / whole : 1;
    model.order.floor = remesh_error * remesh_error;
    if (source.options.profile == Profile::Fast) model.order.least_planes = kPlanesOfPacked;
    const bool lossless = source.options.lossless > 0;
    const TransformKind kind = lossless ? TransformKind::ButterflyLazy : source.options.transform.kind;
    model.header.transform = static_cast<std::uint8_t>(kind);
}

/// Fewer, longer chunks until what is not payload is a small share of the file.
Result<Bytes> plan_file(CodedModel& model, std::vector<PlannedChunk>& plan) {
    for (;; model.order.least_bytes *= 1.5, model.order.least_share *= 1.5) {
        plan = order_chunks(model.parts, model.order);
        Result<Bytes> file = write_file(model.header, to_write(plan));
        if (!file.ok()) return file;
        double payload = 0;
        for (const PlannedChunk& c : plan) payload += double(c.payload.size());
        const auto size = double(file->size());
        if (size - payload < kMostOverhead * size || model.order.least_bytes > kLongestLeastBytes) return file;
    }
}

/// How good a file is, by what it decodes to.
struct Quality {
    double mean = 0;   // PSNR of the whole chunks in beginnings that matter, of kBudgets sizes
    double whole = 0;  // PSNR of all of it
};

/// Measures longer and longer beginnings of a file.
class Beginnings {
 public:
    Beginnings(const EncoderInput& input, ByteSpan file, unsigned threads)
        : input_(input), file_(file), threads_(threads) {}

    double psnr_of_first(double bytes) {
        const std::size_t end = std::clamp(static_cast<std::size_t>(bytes), fed_, file_.size());
        (void)decoder_.feed(file_.subspan(fed_, end - fed_)).ok();
        fed_ = end;
        const Result<Mesh> mesh = decoder_.mesh();
        if (!mesh.ok() || !measurable(*mesh)) return kNothing;
        return std::min(input_.reference().error_of(*mesh, {kSamplesForChoice, threads_, kVertexStride}).psnr, kExact);
    }
    /// Mean over the first `budgets` of kBudgets sizes, none below `floor` bytes.
    double mean(unsigned budgets, double floor = kLeastBudget) {
        const double least = std::max(floor, least_beginning(input_));
        const double most = std::max(
            {2 * least, kLeastRange * least_beginning(input_), kMostBits / 8 * double(input_.mesh().positions.size())});
        double sum = 0;
        for (unsigned k = 0; k < budgets; ++k)
            sum += psnr_of_first(least * std::pow(most / least, double(k) / (kBudgets - 1)));
        return sum / budgets;
    }

 private:
    const EncoderInput& input_;
    const ByteSpan file_;
    const unsigned threads_;
    Decoder decoder_;
    std::size_t fed_ = 0;
};

Quality quality_of(const EncoderInput& input, ByteSpan file, unsigned threads) {
    Beginnings beginnings(input, file, threads);
    const double mean = beginnings.mean(kBudgets);
    return {mean, beginnings.psnr_of_first(double(file.size()))};
}

Result<void> add_original(const Mesh& input, const FileHeader& header, const EncodeOptions& options,
                          std::vector<PlannedChunk>& plan) {
    if (options.keep_original == 0) return {};
    PlannedChunk chunk;
    chunk.id.channel = Channel::Original;
    chunk.payload = write_original(input, header, options.keep_original);
    chunk.error = plan.back().error;
    if (chunk.payload.empty()) return Error{Errc::InvalidArgument, 0, "Draco cannot code the original mesh"};
    plan.push_back(std::move(chunk));
    return {};
}

void report_attributes(const CodedModel& model, const std::vector<PlannedChunk>& plan, Encoded& out) {
    for (const CodedPart& part : model.parts)
        for (const AttributeParams& a : part.attributes) {
            const std::string name = attribute_name(a);
            const auto known = std::ranges::find(out.attributes, name, &AttributeBytes::name);
            AttributeBytes& entry =
                known != out.attributes.end() ? *known : out.attributes.emplace_back(AttributeBytes{name, 0});
            for (const PlannedChunk& c : plan)
                if (c.id.channel == a.channel && &model.parts[c.id.part] == &part) entry.bytes += c.payload.size();
        }
}

void report(const CodedModel& model, const std::vector<PlannedChunk>& plan, Encoded& out) {
    double in_wavelets = 0;
    for (const CodedPart& part : model.parts) {
        const auto vertices = double(part.mesh.positions.size());
        out.vertices += part.mesh.positions.size();
        out.base_faces += part.mesh.base.face_count();
        out.levels = std::max(out.levels, part.mesh.levels);
        out.tangential_share += part.tangential_share * vertices;
        if (part.mesh.levels > 0) in_wavelets += vertices;
    }
    if (in_wavelets > 0) out.tangential_share /= in_wavelets;
    for (const PlannedChunk& c : plan) {
        const bool closing = model.header.parts[c.id.part].supersedes;
        if (closing) out.closing_bytes += c.payload.size();
        if (leads_to_base(c.id.channel) && !closing) out.base_bytes += c.payload.size();
        if (c.id.channel == Channel::Color) out.color_bytes += c.payload.size();
        if (c.id.channel == Channel::Original) out.original_bytes += c.payload.size();
    }
    report_attributes(model, plan, out);
    std::set<std::uint32_t> colored;
    for (const CodedPart& part : model.parts)
        for (const MaterialColor& c : part.params.colors) colored.insert(c.label);
    out.material_colors = static_cast<std::uint32_t>(colored.size());
    out.parts = static_cast<std::uint32_t>(model.parts.size());
    out.transform = TransformKind{model.header.transform};
}

/// One way to code a source.
struct Coded {
    CodedModel model;
    std::vector<PlannedChunk> plan;
    Bytes file;
};

std::optional<Closing> close_where_it_pays(const Source& source, const Coded& coded, const SurfaceError& whole,
                                           const EncodeOptions& options) {
    const bool chosen = options.base_faces > 0 || options.levels >= 0 || options.target_error > 0;
    const bool plain = std::ranges::all_of(coded.model.parts, [](const CodedPart& p) { return p.attributes.empty(); });
    const auto has = [&](PartOrigin o) { return std::ranges::find(source.origins, o) != source.origins.end(); };
    // Where no wavelets may be wrong, what is semi-regular already is kept, and what is short is there at once.
    const bool is_short = double(coded.file.size()) <= least_beginning(source.input);
    const bool stays = !has(PartOrigin::Remeshed) && (has(PartOrigin::Recognized) || is_short);
    const bool fits = coded.model.parts.size() + kMostStages <= Limits{}.max_parts;
    if (!options.close || chosen || !plain || stays || !fits || options.lossless > 0) return std::nullopt;
    return close(
        source.input, {coded.model.header, coded.plan, whole},
        {options.profile == Profile::Fast, options.choose_transform && options.tile_count == 0, options.threads});
}

}  // namespace

struct Draft::State {
    Source source;
    CodedModel described;  // no parts yet
    BaseGrid grid;
    Coded coded;

    Result<Coded> code(const BaseGrid& with, unsigned threads, const Painter* painter = nullptr) const {
        Coded out{described, {}, {}};
        code_parts(source, with, painter, threads, out.model);
        Result<Bytes> file = plan_file(out.model, out.plan);
        if (!file.ok()) return file.error();
        out.file = std::move(*file);
        return out;
    }
    [[nodiscard]] std::optional<Quality> measure(const BaseGrid& with, unsigned threads) const {
        const Result<Coded> other = code(with, threads);
        if (!other.ok()) return std::nullopt;
        return quality_of(source.input, other->file, threads);
    }
};

double least_beginning(const EncoderInput& input) {
    return std::max(kLeastBudget, kLeastBits / 8 * double(input.mesh().positions.size()));
}

Draft::Draft(std::unique_ptr<State> state) : state_(std::move(state)) {}
Draft::~Draft() = default;
Draft::Draft(Draft&&) noexcept = default;
Draft& Draft::operator=(Draft&&) noexcept = default;

Result<Draft> Draft::make(EncoderInput& input, RemeshResult remeshed, const EncodeOptions& options,
                          const BaseGrid& grid) {
    auto state = std::make_unique<State>(State{adapt(input, std::move(remeshed), options), {}, grid, {}});
    describe(state->source, state->described);
    Result<Coded> coded = state->code(grid, options.threads);
    if (!coded.ok()) return coded.error();
    state->coded = std::move(*coded);
    return Draft(std::move(state));
}

double Draft::score() const {
    return score_from(kLeastBudget);
}

double Draft::score_from(double floor) const {
    return Beginnings(state_->source.input, state_->coded.file, state_->source.options.threads)
        .mean(kBudgetsOfScore, std::max(floor, kLeastBudget));
}

double Draft::base_bytes() const {
    double bytes = 0;
    for (const PlannedChunk& chunk : state_->coded.plan)
        if (chunk.id.channel == Channel::Base) bytes += double(chunk.payload.size());
    return bytes;
}

double Draft::remeshing_error() const {
    return std::sqrt(state_->described.order.floor);
}

BaseGrid Draft::best_grid(unsigned threads) const {
    const State& s = *state_;
    constexpr BaseGrid kPlain{false, 0}, kFine{true, 1};
    const auto adapted = [](const auto& adaptation) { return adaptation != nullptr; };
    if (std::none_of(s.source.adaptations.begin(), s.source.adaptations.end(), adapted)) return s.grid;
    std::optional<Quality> plain, fine;
    const auto measure_plain = [&](unsigned share) { plain = s.measure(kPlain, share); };
    const auto measure_fine = [&](unsigned share) { fine = s.measure(kFine, share); };
    if (finest_mesh(s.source.parts).positions.size() <= kMostSideBySide) {
        side_by_side(threads, measure_plain, measure_fine);
    } else {  // each takes memory
        measure_plain(threads);
        measure_fine(threads);
    }
    if (!plain || !fine) return s.grid;
    const double least_whole = std::min(plain->whole - kMostLost, kEnough);
    const auto worth = [&](const Quality& quality) { return quality.whole >= least_whole ? quality.mean : -kExact; };
    const double coarse = worth(quality_of(s.source.input, s.coded.file, threads));
    if (worth(*plain) > std::max(coarse, worth(*fine))) return kPlain;
    return worth(*fine) > coarse ? kFine : s.grid;
}

Result<void> Draft::lay_bases(const BaseGrid& grid, unsigned threads) {
    if (grid == state_->grid) return {};
    Result<Coded> coded = state_->code(grid, threads);
    if (!coded.ok()) return coded.error();
    state_->coded = std::move(*coded);
    state_->grid = grid;
    return {};
}

/// Colours that images and materials give are those where the coded vertices are.
Result<void> Draft::paint(const EncodeOptions& options, Encoded& out) {
    State& s = *state_;
    const Mesh& input = s.source.input.mesh();
    if (!input.paintwork || options.lossless > 0) return {};
    if (options.progress) options.progress("paint", 0);
    const FileHeader& header = s.source.input.header();
    const Vec3 center{header.center[0], header.center[1], header.center[2]};
    const Painter painter(*input.paintwork, center, header.diagonal, options.threads);
    Result<Coded> painted = s.code(s.grid, options.threads, &painter);
    if (!painted.ok()) return painted.error();
    s.coded = std::move(*painted);
    for (std::size_t p = 0; p < s.source.parts.size(); ++p) {
        const SemiRegularMesh& part = s.coded.model.parts[p].mesh;
        out.color_levels = std::max(out.color_levels, part.levels - s.source.parts[p].levels);
        out.painted_vertices += part.colors.size();
    }
    if (options.progress) options.progress("paint", 1);
    return {};
}

Result<void> Draft::finish(const EncodeOptions& options, Encoded& out) {
    State& s = *state_;
    if (const Result<void> r = paint(options, out); !r.ok()) return r;
    s.source.adaptations.clear();  // memory
    order_by_measure(s.source.input, s.coded.file, s.coded.plan, options);
    const bool fast = options.profile == Profile::Fast;
    if (options.lossless == 0) cut_end(s.source.input, s.coded.file, s.coded.plan, fast, options.threads);
    if (!fast) {  // whose cut chunks show nothing
        const Result<Bytes> ordered = write_file(s.coded.model.header, to_write(s.coded.plan));
        if (!ordered.ok()) return ordered.error();
        say_least_bytes(s.source.input, *ordered, s.coded.plan, options.threads);
    }
    SurfaceError error = measure_errors(s.source.input, s.coded.file, s.coded.plan, options);
    bool is_plain = false;
    if (std::optional<Closing> closing = close_where_it_pays(s.source, s.coded, error, options)) {
        s.coded.model.header = std::move(closing->header);
        s.coded.plan = std::move(closing->plan);
        is_plain = !closing->plain.empty();
        if (is_plain) s.coded.model.parts = std::move(closing->plain);
        Result<Bytes> closed = write_file(s.coded.model.header, to_write(s.coded.plan));
        if (!closed.ok()) return closed.error();
        s.coded.file = std::move(*closed);
        error = measure_errors(s.source.input, s.coded.file, s.coded.plan, options);
    }
    if (const Result<void> r = add_original(s.source.input.mesh(), s.coded.model.header, options, s.coded.plan);
        !r.ok())
        return r;
    Result<Bytes> file = write_file(s.coded.model.header, to_write(s.coded.plan));
    if (!file.ok()) return file.error();
    out.file = std::move(*file);
    if (!is_plain) {
        out.draco_area_share = s.source.alone_area_share;
        out.facets_area_share = s.source.facets_area_share;
    }
    out.rms = error.rms;
    out.max = error.max;
    out.psnr = error.psnr;
    report(s.coded.model, s.coded.plan, out);
    return {};
}

}  // namespace mvw
