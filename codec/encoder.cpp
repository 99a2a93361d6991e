#include "codec/encoder.h"

#include <algorithm>
#include <thread>

#include "codec/enc_remeshed.h"
#include "codec/enc_slide.h"
#include "codec/measure/surface_error.h"

namespace mvw {

namespace {

constexpr std::size_t kMostToTry = 150'000;  // vertices of a model for which several remeshes are made
constexpr double kBaseFactor = 1.6;          // from one base to the next
constexpr unsigned kTries = 2;               // of other bases
constexpr double kLeastGain = 0.1;           // dB; less is chance
constexpr double kMostLoss = 1.3;            // of the remeshing error, against that of the first base, ...
constexpr double kSmallError = 3e-5;         // ... or what is small of the diagonal

/// The faces of the input that one part stands for; its vertices are all of the input's.
Mesh input_of(const Mesh& input, const RemeshResult& remeshed, std::uint32_t part) {
    Mesh out{input.positions, {}, input.colors, {}};
    for (std::size_t f = 0; f < input.faces.size(); ++f)
        if (remeshed.part_of_face[f] == part) out.faces.push_back(input.faces[f]);
    return out;
}

void slide_parts(const Mesh& input, const EncodeOptions& options, RemeshResult& remeshed) {
    const unsigned threads = options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    for (std::uint32_t part = 0; part < remeshed.parts.size(); ++part) {
        if (remeshed.parts[part].levels > 0 && remeshed.own_vertices[part] == 0)
            slide(input_of(input, remeshed, part), options.transform, threads, remeshed.parts[part]);
        if (options.progress) options.progress("slide", double(part + 1) / double(remeshed.parts.size()));
    }
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
    const bool plain = remeshed.parts.size() == 1 && remeshed.parts[0].levels > 0 && remeshed.own_vertices[0] == 0;
    return !chosen && plain && mesh.positions.size() <= kMostToTry ? remeshed.parts[0].base.face_count() : 0;
}

/// Parts whose vertices are all the input's: semi-regular ones, and small components beside them as they are.
Result<RemeshResult> own_parts(const Mesh& mesh, const EncodeOptions& options) {
    RemeshResult remeshed = remesh(mesh, remeshing_of(options, 0));
    bool any = false, all = true;
    for (std::size_t p = 0; p < remeshed.parts.size(); ++p) {
        any = any || remeshed.own_vertices[p] != 0;
        all = all && (remeshed.own_vertices[p] != 0 || remeshed.parts[p].levels == 0);
    }
    if (any && all) return remeshed;
    return Error{Errc::InvalidArgument, 0,
                 "the mesh has no subdivision connectivity of two levels or more, which lossless coding needs "
                 "(--keep-original keeps any mesh)"};
}

Result<Draft> lossless_draft(const Mesh& mesh, const EncodeOptions& options) {
    Result<RemeshResult> parts = own_parts(mesh, options);
    return parts.ok() ? Draft::make(mesh, std::move(*parts), options) : Result<Draft>(parts.error());
}

/// The draft of the base that measures best. Sharp models may want larger bases than decimation stops at, smooth ones
/// smaller ones.
Result<Draft> best_draft(const Mesh& mesh, const EncodeOptions& options) {
    const auto make = [&](RemeshResult remeshed) {
        slide_parts(mesh, options, remeshed);
        return Draft::make(mesh, std::move(remeshed), options);
    };
    if (options.lossless > 0) return lossless_draft(mesh, options);
    RemeshResult remeshed = remesh(mesh, remeshing_of(options, options.base_faces));
    const unsigned base = base_to_vary(mesh, remeshed, options);
    const double factor = base > 0 && remeshed.parts[0].creases.empty() ? 1 / kBaseFactor : kBaseFactor;
    Result<Draft> best = make(std::move(remeshed));
    if (base == 0 || !best.ok()) return best;
    const double most_error = kMostLoss * std::max(best->remeshing_error(), kSmallError);
    double faces = base * factor;
    for (unsigned k = 0; k < kTries; ++k, faces *= factor) {
        Result<Draft> other = make(remesh(mesh, remeshing_of(options, static_cast<unsigned>(faces))));
        if (!other.ok()) return other;
        if (other->remeshing_error() > most_error || other->score() < best->score() + kLeastGain) break;
        best = std::move(other);
    }
    return best;
}

}  // namespace

Result<Encoded> encode(Mesh mesh, const EncodeOptions& options) {
    Encoded out;
    mesh = clean(std::move(mesh), out.cleaning);
    if (!measurable(mesh)) return Error{Errc::InvalidArgument, 0, "no face of positive area is left to encode"};
    out.input_vertices = mesh.positions.size();
    out.input_faces = mesh.faces.size();
    Result<Draft> draft = best_draft(mesh, options);
    if (!draft.ok()) return draft.error();
    if (const Result<void> r = draft->finish(out); !r.ok()) return r.error();
    return out;
}

}  // namespace mvw
