#include "codec/enc_remeshed.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "codec/container/enc_file.h"
#include "codec/decoder.h"
#include "codec/enc_errors.h"
#include "codec/enc_original.h"
#include "codec/enc_snap.h"
#include "codec/measure/surface_error.h"

namespace mvw {

namespace {

constexpr std::uint32_t kSamplesForRemeshing = 40'000;
constexpr double kRoundingShare = 0.4;      // of the remeshing error may be added by rounding
constexpr double kFinestRounding = 4e-6;    // where remeshing leaves nothing
constexpr double kFinestAlone = 2e-5;       // of parts that Draco codes alone
constexpr double kVerticesOfTile = 32'768;  // a tile has at least so many, so that its chunks are worth their heads
constexpr unsigned kMostTiles = 64;
constexpr std::uint64_t kLeastOfTile = 8192;  // coarser levels, where tiles would have fewer vertices, are not tiled
constexpr std::size_t kLongestLeastBytes = 8192;
constexpr double kCellsOfEdge = 8;  // of the grid that bases are snapped to, for each of a base's edges
constexpr std::uint32_t kSamplesForChoice = 20'000;
constexpr unsigned kBudgets = 5;         // sizes at which files are compared, ...
constexpr double kLeastBudget = 1024;    // ... none below
constexpr double kMostLost = 0.7;        // dB of the whole file that better beginnings may cost, ...
constexpr double kEnough = 84;           // ... unless it stays above this
constexpr double kNothing = 35;          // PSNR that a beginning too short for any surface counts as
constexpr double kExact = 150;           // and the most that any does
constexpr double kMostOverhead = 0.045;  // of the file: heads, header, index

double area(const Mesh& mesh) {
    double sum = 0;
    for (const Face& f : mesh.faces)
        sum += length(cross(mesh.positions[f[1]] - mesh.positions[f[0]], mesh.positions[f[2]] - mesh.positions[f[0]]));
    return sum / 2;
}

Mesh finest_mesh(const std::vector<SemiRegularMesh>& parts) {
    Mesh out;
    for (const SemiRegularMesh& part : parts) {
        const auto first = static_cast<std::uint32_t>(out.positions.size());
        out.positions.insert(out.positions.end(), part.positions.begin(), part.positions.end());
        for (const Face& f : triangles_at_level(part.base, part.levels))
            out.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    }
    return out;
}

Result<void> box_of(const Mesh& input, FileHeader& header) {
    const Box box = bounding_box(input);
    const Vec3 c = box.center();
    return set_box(header, {c.x, c.y, c.z}, box.diagonal());
}

PartPrecision precision_of(const SemiRegularMesh& part, const EncodeOptions& options, double remesh_error) {
    PartPrecision precision;
    precision.fast = options.profile == Profile::Fast;
    precision.lossless = options.lossless;
    // What remeshing leaves of the wanted error, else a share of what it left.
    const double t = options.target_error, r = remesh_error;
    precision.error = std::max(t > r * 1.1 ? 0.9 * std::sqrt(t * t - r * r) : r * kRoundingShare, kFinestRounding);
    if (part.levels == 0) {
        // A step s of the grid leaves s / sqrt(12) along the normal. Finer than 14 bits only where it was asked for.
        const double error = t > 0 ? precision.error : std::max(precision.error, kFinestAlone);
        precision.base_bits = static_cast<unsigned>(std::clamp(std::ceil(-std::log2(error * 3.4)), 10.0, 20.0));
        return precision;
    }
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

unsigned layers_of(const std::vector<CodedPart>& parts) {
    unsigned layers = 1;
    for (const CodedPart& part : parts)
        for (const CodedBlock& block : part.blocks)
            if (!block.planes.planes.empty()) layers = std::max(layers, block.planes.planes.front().plane + 1);
    return layers;
}

std::vector<ChunkToWrite> to_write(const std::vector<PlannedChunk>& plan) {
    std::vector<ChunkToWrite> out;
    for (const PlannedChunk& c : plan) out.push_back({c.id, c.payload, static_cast<float>(c.error)});
    return out;
}

/// Everything about the parts that the chunks' order needs.
struct CodedModel {
    FileHeader header;
    std::vector<CodedPart> parts;
    OrderOptions order;
};

double remeshing_error(const Mesh& input, const std::vector<SemiRegularMesh>& parts, const EncodeOptions& options) {
    return surface_error(input, finest_mesh(parts), {kSamplesForRemeshing, options.threads}).rms;
}

/// A file keeps s as a float: the encoder has to transform with that one.
TransformOptions as_stored(TransformOptions transform) {
    if (transform.s != TransformOptions{}.s) transform.s = static_cast<double>(static_cast<float>(transform.s));
    return transform;
}

/// The faces of the input that one part stands for, in coded units; vertices are all of the input's.
Mesh surface_of(const Mesh& input, const std::vector<std::uint32_t>& part_of_face, std::uint32_t part,
                const FileHeader& header) {
    Mesh out;
    const Vec3 center{header.center[0], header.center[1], header.center[2]};
    for (const Vec3& p : input.positions) out.positions.push_back((p - center) / header.diagonal);
    for (std::size_t f = 0; f < input.faces.size(); ++f)
        if (part_of_face[f] == part) out.faces.push_back(input.faces[f]);
    return out;
}

/// What is to be coded, and how finely each part.
struct Source {
    const Mesh& input;
    const EncodeOptions& options;
    RemeshResult remeshed;  // positions in coded units
    std::vector<PartPrecision> precision;
    unsigned threads = 1;
};

/// Bits of a grid whose cells are a small part of a base edge.
unsigned bits_of_snap(const SemiRegularMesh& mesh) {
    double sum = 0;
    for (const BaseEdge& e : mesh.base.edges()) sum += length(mesh.positions[e.v[0]] - mesh.positions[e.v[1]]);
    const double mean = sum / double(mesh.base.edge_count());
    return static_cast<unsigned>(std::clamp(std::round(std::log2(kCellsOfEdge / mean)), 4.0, 12.0));
}

bool can_snap(const Source& source, std::uint32_t part) {
    return source.options.lossless == 0 && source.remeshed.parts[part].levels > 0 &&
           source.remeshed.own_vertices[part] == 0;
}

/// snapped: whether remeshed parts are adapted to bases of few bits; finer: by so many more bits.
void code_parts(const Source& source, bool snapped, unsigned finer, CodedModel& model) {
    model.parts.clear();
    const TransformOptions transform = as_stored(source.options.transform);
    for (std::uint32_t p = 0; p < source.remeshed.parts.size(); ++p) {
        PartPrecision precision = source.precision[p];
        const SemiRegularMesh& mesh = source.remeshed.parts[p];
        if (!snapped || !can_snap(source, p)) {
            model.parts.push_back(code_part(mesh, transform, precision, {}, source.threads));
            continue;
        }
        SemiRegularMesh adapted = mesh;
        precision.base_bits = bits_of_snap(mesh) + finer;
        const PartUnits::Grid grid = snap(surface_of(source.input, source.remeshed.part_of_face, p, model.header),
                                          transform, precision.base_bits, source.threads, adapted);
        model.parts.push_back(code_part(adapted, transform, precision, grid, source.threads));
    }
    model.order.layers = layers_of(model.parts);
    model.header.layers = static_cast<std::uint8_t>(model.order.layers);
}

Source prepare(const Mesh& input, RemeshResult remeshed, const EncodeOptions& options, CodedModel& model) {
    const double remesh_error = remeshing_error(input, remeshed.parts, options);
    const Vec3 center{model.header.center[0], model.header.center[1], model.header.center[2]};
    Source source{input, options, std::move(remeshed), {}, options.threads};
    if (source.threads == 0) source.threads = std::max(1u, std::thread::hardware_concurrency());
    double whole = 0;
    for (SemiRegularMesh& mesh : source.remeshed.parts) {
        model.order.area_share.push_back(area(finest_mesh({mesh})));
        whole += model.order.area_share.back();
        source.precision.push_back(precision_of(mesh, options, remesh_error));
        for (Vec3& p : mesh.positions) p = (p - center) / model.header.diagonal;
        model.header.parts.push_back(info_of(mesh, source.precision.back()));
    }
    for (double& share : model.order.area_share) share = whole > 0 ? share / whole : 1;
    model.order.floor = remesh_error * remesh_error;
    const TransformKind kind = options.lossless > 0 ? TransformKind::ButterflyLazy : options.transform.kind;
    model.header.transform = static_cast<std::uint8_t>(kind);
    return source;
}

/// Fewer, longer chunks until what is not payload is a small share of the file.
Result<Bytes> plan_file(CodedModel& model, std::vector<PlannedChunk>& plan) {
    for (;; model.order.least_bytes = model.order.least_bytes * 3 / 2) {
        plan = order_chunks(model.parts, model.order);
        Result<Bytes> file = write_file(model.header, to_write(plan));
        if (!file.ok()) return file;
        double payload = 0;
        for (const PlannedChunk& c : plan) payload += double(c.payload.size());
        const auto size = double(file->size());
        if (size - payload < kMostOverhead * size || model.order.least_bytes > kLongestLeastBytes) return file;
    }
}

/// PSNR of a file's first bytes.
double psnr_of(const Source& source, ByteSpan file, double bytes) {
    Decoder decoder;
    (void)decoder.feed(file.first(static_cast<std::size_t>(std::min(bytes, double(file.size()))))).ok();
    decoder.finish();
    const Result<Mesh> mesh = decoder.mesh();
    if (!mesh.ok() || !measurable(*mesh)) return kNothing;
    return std::min(surface_error(source.input, *mesh, {kSamplesForChoice, source.threads}).psnr, kExact);
}

/// Mean PSNR of a file's beginnings, of sizes that matter: from 0.2 to 3 bits for each of the input's vertices.
double score(const Source& source, ByteSpan file) {
    const double bits = double(source.input.positions.size()) / 8;
    const double least = std::max(kLeastBudget, 0.2 * bits), most = std::max(2 * least, 3 * bits);
    double sum = 0;
    for (unsigned k = 0; k < kBudgets; ++k)
        sum += psnr_of(source, file, least * std::pow(most / least, double(k) / (kBudgets - 1)));
    return sum / kBudgets;
}

/// Of the ways to lay the bases: the one whose file measures best, if the whole file is as good as without or enough.
Result<Bytes> best_file(const Source& source, CodedModel& model, std::vector<PlannedChunk>& plan, double& best_score) {
    struct Way {
        bool snapped;
        unsigned finer;
    };
    std::vector<Way> ways{{false, 0}};
    for (std::uint32_t p = 0; p < source.remeshed.parts.size() && ways.size() == 1; ++p)
        if (can_snap(source, p)) ways.insert(ways.end(), {{true, 0}, {true, 1}});
    const CodedModel start = model;
    Bytes best;
    double least_whole = 0;
    for (std::size_t w = 0; w < ways.size(); ++w) {
        CodedModel tried = start;
        std::vector<PlannedChunk> tried_plan;
        code_parts(source, ways[w].snapped, ways[w].finer, tried);
        Result<Bytes> file = plan_file(tried, tried_plan);
        if (!file.ok()) return file;
        const double s = ways.size() > 1 ? score(source, *file) : 0;
        if (source.options.progress) source.options.progress("choose", double(w + 1) / double(ways.size()));
        const double whole = ways.size() > 1 ? psnr_of(source, *file, double(file->size())) : 0;
        if (w == 0) least_whole = std::min(whole - kMostLost, kEnough);
        if (w > 0 && (s <= best_score || whole < least_whole)) continue;
        best = std::move(*file), best_score = s;
        model = std::move(tried), plan = std::move(tried_plan);
    }
    return best;
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
        if (c.id.channel == Channel::Base) out.base_bytes += c.payload.size();
        if (c.id.channel == Channel::Color) out.color_bytes += c.payload.size();
        if (c.id.channel == Channel::Original) out.original_bytes += c.payload.size();
    }
    out.parts = static_cast<std::uint32_t>(model.parts.size());
    out.transform = TransformKind{model.header.transform};
}

}  // namespace

struct Draft::State {
    const Mesh& input;
    const EncodeOptions& options;
    CodedModel model;
    std::vector<PlannedChunk> plan;
    Bytes file;
    double score = 0, alone_area_share = 0;
};

Draft::Draft(std::unique_ptr<State> state) : state_(std::move(state)) {}
Draft::~Draft() = default;
Draft::Draft(Draft&&) noexcept = default;
Draft& Draft::operator=(Draft&&) noexcept = default;

Result<Draft> Draft::make(const Mesh& input, RemeshResult remeshed, const EncodeOptions& options) {
    auto state = std::make_unique<State>(State{input, options, {}, {}, {}, 0, remeshed.alone_area_share});
    if (const Result<void> r = box_of(input, state->model.header); !r.ok()) return r.error();
    const Source source = prepare(input, std::move(remeshed), options, state->model);
    Result<Bytes> file = best_file(source, state->model, state->plan, state->score);
    if (!file.ok()) return file.error();
    state->file = std::move(*file);
    return Draft(std::move(state));
}

double Draft::score() const {
    return state_->score;
}

double Draft::remeshing_error() const {
    return std::sqrt(state_->model.order.floor);
}

Result<void> Draft::finish(Encoded& out) {
    State& s = *state_;
    const SurfaceError error = measure_errors(s.input, s.file, s.plan, s.options);
    if (const Result<void> r = add_original(s.input, s.model.header, s.options, s.plan); !r.ok()) return r;
    Result<Bytes> file = write_file(s.model.header, to_write(s.plan));
    if (!file.ok()) return file.error();
    out.file = std::move(*file);
    out.draco_area_share = s.alone_area_share;
    out.rms = error.rms;
    out.max = error.max;
    out.psnr = error.psnr;
    report(s.model, s.plan, out);
    return {};
}

Result<void> encode_remeshed(const Mesh& input, RemeshResult remeshed, const EncodeOptions& options, Encoded& out) {
    Result<Draft> draft = Draft::make(input, std::move(remeshed), options);
    return draft.ok() ? draft->finish(out) : Result<void>(draft.error());
}

}  // namespace mvw
