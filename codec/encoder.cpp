#include "codec/encoder.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "codec/enc_remeshed.h"
#include "codec/remesh/parallel.h"

namespace mvw {

namespace {

constexpr std::size_t kMostToTry = 150'000;  // vertices of a model for which several remeshes are made
constexpr double kBaseFactor = 1.6;          // from one base to the next
constexpr double kMostGrowth = 8;            // of vertices: so far, or up to few, a larger base keeps its levels
constexpr double kLeastGain = 0.1;           // dB; less is chance
constexpr double kMostLoss = 1.3;            // of the remeshing error, against that of the first base, ...
constexpr double kSmallError = 6e-5;         // ... or what is small of the diagonal

EncodeOptions with_threads(EncodeOptions options, unsigned threads) {
    options.threads = threads;
    return options;
}

RemeshOptions remeshing_of(const EncodeOptions& options, unsigned base_faces) {
    RemeshOptions remeshing;
    remeshing.base_faces = base_faces;
    remeshing.levels = options.levels;
    remeshing.target_error = options.target_error;
    remeshing.threads = options.threads;
    remeshing.progress = options.progress;
    return remeshing;
}

/// Faces of the base where other bases can be tried: one part, remeshed by default, of no more than kMostToTry
/// vertices; else 0.
unsigned base_to_vary(const Mesh& mesh, const RemeshResult& remeshed, const EncodeOptions& options) {
    const bool chosen = options.base_faces > 0 || options.levels >= 0 || options.target_error > 0;
    const bool plain = remeshed.parts.size() == 1 && remeshed.origins[0] == PartOrigin::Remeshed;
    return !chosen && plain && mesh.positions.size() <= kMostToTry ? remeshed.parts[0].base.face_count() : 0;
}

/// Parts whose vertices are all the input's: semi-regular ones, and small components beside them as they are.
Result<RemeshResult> own_parts(const Mesh& mesh, const EncodeOptions& options) {
    RemeshResult remeshed = remesh(mesh, remeshing_of(options, 0));
    bool any = false, all = true;
    for (const PartOrigin origin : remeshed.origins) {
        any = any || origin == PartOrigin::Recognized;
        all = all && origin != PartOrigin::Remeshed;
    }
    if (any && all) return remeshed;
    return Error{Errc::InvalidArgument, 0,
                 "the mesh has no subdivision connectivity of two levels or more, which lossless coding needs "
                 "(--keep-original keeps any mesh)"};
}

/// The draft of the base that measures best of three: that where decimation stops, one 1.6 times larger (sharp models)
/// or smaller, and the next in the better direction. Two drafts are made at a time. base: faces of the first one.
/// remeshing: of the first one, then of the one taken.
Result<Draft> best_of_bases(EncoderInput& input, RemeshResult remeshed, unsigned base, const EncodeOptions& options,
                            RemeshOptions& remeshing) {
    const double factor = remeshed.parts[0].creases.empty() ? 1 / kBaseFactor : kBaseFactor;
    const auto levels = static_cast<int>(remeshed.parts[0].levels);
    const double most_vertices = std::max(kFewVertices, kMostGrowth * double(input.mesh().positions.size()));
    const auto remeshing_at = [&](int steps, const EncodeOptions& with) {
        const double faces = base * std::pow(factor, steps);
        const bool keeps_levels = faces > base && faces * std::pow(4, levels) / 2 <= most_vertices;
        RemeshOptions other = remeshing_of(with, static_cast<unsigned>(faces));
        other.levels = keeps_levels ? levels : -1;
        other.feature_angle_deg = remeshing.feature_angle_deg;
        return other;
    };
    const auto draft_at = [&](int steps, const EncodeOptions& with) {
        return Draft::make(input, remesh(input.mesh(), remeshing_at(steps, with)), with);
    };
    std::optional<Result<Draft>> first, second;
    const auto measured = [](Result<Draft> draft) {
        if (draft.ok()) (void)draft->score();
        return draft;
    };
    side_by_side(
        options.threads,
        [&](unsigned threads) {
            first = measured(Draft::make(input, std::move(remeshed), with_threads(options, threads)));
        },
        [&](unsigned threads) {
            EncodeOptions silent = with_threads(options, threads);
            silent.progress = {};
            second = measured(draft_at(1, silent));
        });
    if (!first->ok()) return first->error();
    const double most_error = kMostLoss * std::max((*first)->remeshing_error(), kSmallError);
    const auto is_better = [&](Result<Draft>& draft, Draft& than) {
        return draft.ok() && draft->remeshing_error() <= most_error && draft->score() >= than.score() + kLeastGain;
    };
    const bool onwards = is_better(*second, **first);
    Result<Draft> best = std::move(onwards ? *second : *first);
    first.reset(), second.reset();  // memory
    const int next = onwards ? 2 : -1;
    Result<Draft> third = draft_at(next, options);
    const bool takes_third = is_better(third, *best);
    if (takes_third || onwards) remeshing = remeshing_at(takes_third ? next : 1, options);
    return takes_third ? std::move(third) : std::move(best);
}

bool is_sharp(const RemeshResult& remeshed) {
    return std::ranges::any_of(remeshed.parts, [](const SemiRegularMesh& part) { return !part.creases.empty(); });
}

/// The draft of the base and transform that measure best. Only models with sharp edges are tried without lifting, and
/// coded so unless that is worse: where parts are thinner than base faces, what lifting adds to coarse levels
/// overshoots.
Result<Draft> best_draft(EncoderInput& input, const EncodeOptions& options) {
    RemeshOptions remeshing = remeshing_of(options, options.base_faces);
    RemeshResult remeshed = remesh(input.mesh(), remeshing);
    remeshing.feature_angle_deg = remeshed.feature_angle_deg;
    const bool tries_lazy = is_sharp(remeshed) && options.choose_transform &&
                            options.transform.kind == TransformKind::SeededNormal &&
                            input.mesh().positions.size() <= kMostToTry;
    const unsigned base = base_to_vary(input.mesh(), remeshed, options);
    Result<Draft> best = base == 0 ? Draft::make(input, std::move(remeshed), options)
                                   : best_of_bases(input, std::move(remeshed), base, options, remeshing);
    if (!best.ok() || !tries_lazy) return best;
    EncodeOptions lazy = options;
    lazy.transform.kind = TransformKind::SeededNormalLazy;
    Result<Draft> other = Draft::make(input, remesh(input.mesh(), remeshing), lazy);
    return other.ok() && other->score() > best->score() - kLeastGain ? std::move(other) : std::move(best);
}

/// Whether the fields are as VertexField says, each scalar by a name of its own.
bool are_fields_sound(const Mesh& mesh) {
    std::set<std::string> names;
    unsigned normals = 0;
    for (const VertexField& field : mesh.fields) {
        const bool is_scalar = field.kind == FieldKind::Scalar;
        if (field.values.size() != field.components() * mesh.positions.size()) return false;
        if (!std::all_of(field.values.begin(), field.values.end(), [](double x) { return std::isfinite(x); }))
            return false;
        if (!is_scalar && ++normals > 1) return false;
        if (!is_scalar) continue;
        const auto is_good = [](char c) { return c >= '!' && c <= '~'; };
        const bool named = !field.name.empty() && field.name.size() <= kMaxFieldName &&
                           std::all_of(field.name.begin(), field.name.end(), is_good);
        if (!named || !names.insert(field.name).second) return false;
    }
    return true;
}

/// Takes away the fields that are not asked for, or more than a file holds, normals first. Names of the latter.
std::vector<std::string> choose_fields(const EncodeOptions& options, std::vector<VertexField>& fields) {
    std::erase_if(fields, [&](const VertexField& field) {
        return field.kind == FieldKind::Normals ? !options.normals : !options.scalars;
    });
    std::stable_partition(fields.begin(), fields.end(),
                          [](const VertexField& field) { return field.kind == FieldKind::Normals; });
    std::vector<std::string> left_out;
    for (std::size_t k = kMaxFields; k < fields.size(); ++k) left_out.push_back(fields[k].name);
    if (fields.size() > kMaxFields) fields.resize(kMaxFields);
    return left_out;
}

Result<Draft> lossless_draft(EncoderInput& input, const EncodeOptions& options) {
    Result<RemeshResult> parts = own_parts(input.mesh(), options);
    return parts.ok() ? Draft::make(input, std::move(*parts), options) : Result<Draft>(parts.error());
}

}  // namespace

Result<Encoded> encode(Mesh mesh, const EncodeOptions& asked_for) {
    if (!are_fields_sound(mesh))
        return Error{Errc::InvalidArgument, 0,
                     "a field of the vertices has no name of its own, or not a finite value each"};
    Encoded out;
    out.left_out = choose_fields(asked_for, mesh.fields);
    mesh = clean(std::move(mesh), out.cleaning);
    if (!measurable(mesh)) return Error{Errc::InvalidArgument, 0, "no face of positive area is left to encode"};
    out.input_vertices = mesh.positions.size();
    out.input_faces = mesh.faces.size();
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    const EncodeOptions options = with_threads(asked_for, asked_for.threads > 0 ? asked_for.threads : cores);
    const Result<std::unique_ptr<EncoderInput>> input = EncoderInput::make(mesh, options.threads);
    if (!input.ok()) return input.error();
    Result<Draft> draft = options.lossless > 0 ? lossless_draft(**input, options) : best_draft(**input, options);
    if (!draft.ok()) return draft.error();
    if (const Result<void> r = draft->finish(options, out); !r.ok()) return r.error();
    return out;
}

}  // namespace mvw
