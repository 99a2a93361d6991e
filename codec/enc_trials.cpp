#include "codec/enc_trials.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "codec/remesh/parallel.h"

namespace mvw {

namespace {

constexpr std::size_t kMostToTry = 150'000;  // vertices of a model for which bases and transforms are tried
constexpr double kBaseFactor = 1.6;          // from one base to the next
constexpr double kMostGrowth = 8;            // of vertices: so far, or up to few, a larger base keeps its levels
constexpr unsigned kLeastLevels = 3;         // of parts whose finest one trials leave out
constexpr double kLeastGain = 0.1;           // dB; less is chance
constexpr double kMostLoss = 1.3;            // of the remeshing error, against that of the first base, ...
constexpr double kMostLossToShow = 1.6;      // ... where only this one shows something at the least size, ...
constexpr double kSmallError = 7e-5;         // ... or against what is small of the diagonal
constexpr double kFits = 0.93;               // of the least size, for a base together with the file's head
constexpr double kBytesPower = 0.8;          // of its faces, with which a base's bytes grow
constexpr double kErrorOfALevel = 2.5;       // by so much the error is larger where the finest level is left out
constexpr double kBeyondBases = 1.5;         // times the bytes of bases, for transforms to differ
constexpr double kFailed = -std::numeric_limits<double>::infinity();

EncodeOptions with(EncodeOptions options, TransformKind transform, unsigned threads) {
    options.transform.kind = transform;
    options.threads = threads;
    options.progress = {};
    return options;
}

/// A draft and what it measured; none where it could not be coded.
struct Trial {
    std::optional<Draft> draft;
    TransformKind transform = {};
    double score = kFailed, remeshing_error = 0;
    bool shows_early = false;
};

Trial try_out(EncoderInput& input, RemeshResult remeshed, const EncodeOptions& options) {
    Trial trial;
    trial.transform = options.transform.kind;
    Result<Draft> draft = Draft::make(input, std::move(remeshed), options);
    if (!draft.ok()) return trial;
    trial.draft = std::move(*draft);
    trial.score = trial.draft->score();
    trial.remeshing_error = trial.draft->remeshing_error();
    trial.shows_early = trial.draft->base_bytes() <= kFits * least_beginning(input);
    return trial;
}

/// Creases that are more than borders between materials.
bool is_sharp(const SemiRegularMesh& part) {
    for (std::size_t e = 0; e < part.creases.size(); ++e) {
        const auto& [f, g] = part.base.edges()[e].face;
        const bool is_border = !part.materials.empty() && g != kNone && part.materials[f] != part.materials[g];
        if (part.creases[e] != 0 && !is_border) return true;
    }
    return false;
}

bool is_sharp(const RemeshResult& remeshed) {
    return std::ranges::any_of(remeshed.parts, [](const SemiRegularMesh& part) { return is_sharp(part); });
}

unsigned base_faces_of(const RemeshResult& remeshed) {
    unsigned faces = 0;
    for (const SemiRegularMesh& part : remeshed.parts) faces += part.base.face_count();
    return faces;
}

bool tries_lazy(const EncoderInput& input, const RemeshResult& first, const EncodeOptions& options) {
    return options.choose_transform && options.transform.kind == TransformKind::SeededNormal &&
           input.mesh().positions.size() <= kMostToTry && is_sharp(first);
}

/// The one without lifting unless it is worse in beginnings that show more than bases.
Trial better_transform(Trial lifted, Trial lazy) {
    if (!lifted.draft || !lazy.draft) return lazy.draft ? std::move(lazy) : std::move(lifted);
    const double floor = kBeyondBases * std::max(lifted.draft->base_bytes(), lazy.draft->base_bytes());
    const bool is_worse = lazy.draft->score_from(floor) <= lifted.draft->score_from(floor) - kLeastGain;
    return is_worse ? std::move(lifted) : std::move(lazy);
}

/// Whether trials of a remesh leave out the finest level.
bool leaves_out_a_level(const RemeshResult& remeshed) {
    double vertices = 0;
    unsigned levels = 0;
    for (const SemiRegularMesh& part : remeshed.parts) {
        vertices += double(part.positions.size());
        levels = std::max(levels, part.levels);
    }
    return vertices > kFewVertices && levels >= kLeastLevels;
}

/// The same without the finest level of its parts that have enough.
RemeshResult coarser(RemeshResult remeshed) {
    for (SemiRegularMesh& part : remeshed.parts) {
        if (part.levels < kLeastLevels) continue;
        const auto V = static_cast<std::size_t>(vertices_at_level(part.base, --part.levels));
        part.positions.resize(V);
        if (!part.colors.empty()) part.colors.resize(V);
        for (VertexField& field : part.fields) field.values.resize(V * field.components());
    }
    return remeshed;
}

bool has_same_levels(const RemeshResult& remeshed) {
    return std::ranges::all_of(remeshed.parts,
                               [&](const SemiRegularMesh& part) { return part.levels == remeshed.parts[0].levels; });
}

/// Trials of a model with several bases. Where one level is asked for, it is that of all parts.
class BaseTrials {
 public:
    BaseTrials(EncoderInput& input, const RemeshResult& first, const EncodeOptions& options)
        : input_(input),
          options_(options),
          first_(first),
          base_(base_faces_of(first)),
          levels_(first.parts[0].levels),
          same_levels_(has_same_levels(first)),
          sharp_(is_sharp(first)),
          leaves_out_(leaves_out_a_level(first)) {}

    /// The best base's trial; best_faces() says which that is.
    Trial run() {
        const TransformKind transform = options_.transform.kind;
        const double step = sharp_ ? kBaseFactor : 1 / kBaseFactor;
        std::optional<Trial> first, second;
        side_by_side(
            options_.threads,  //
            [&](unsigned threads) { first = trial(base_, transform, threads); },
            [&](unsigned threads) { second = trial(base_ * step, transform, threads); });
        const double small = leaves_out_ ? kSmallError * kErrorOfALevel : kSmallError;
        error_ = std::max(first->remeshing_error, small);
        const bool onwards = is_better(*second, *first);
        const double fitting = sharp_ ? faces_that_fit(*first, base_) : faces_that_fit(*second, base_ * step);
        const double next = fitting > 0 ? fitting : onwards ? base_ * step * step : base_ / step;
        Trial best = std::move(onwards ? *second : *first);
        first.reset(), second.reset();  // memory
        Trial third = trial(next, transform, options_.threads);
        const bool takes_third = is_better(third, best);
        best_faces_ = takes_third ? next : onwards ? base_ * step : base_;
        return takes_third ? std::move(third) : std::move(best);
    }
    [[nodiscard]] double best_faces() const { return best_faces_; }
    [[nodiscard]] bool is_first(double faces) const { return faces == base_; }

    /// How a file with a base of so many faces is remeshed.
    [[nodiscard]] RemeshOptions remeshing_with(double faces) const {
        RemeshOptions remeshing = remeshing_of(options_);
        remeshing.feature_angle_deg = first_.feature_angle_deg;
        if (!is_first(faces)) remeshing.base_faces = static_cast<unsigned>(faces);
        remeshing.levels = levels_with(faces);
        return remeshing;
    }
    [[nodiscard]] Trial trial(double faces, TransformKind transform, unsigned threads) const {
        const EncodeOptions silent = with(options_, transform, threads);
        if (is_first(faces) && !leaves_out_) return try_out(input_, first_, silent);
        RemeshOptions remeshing = remeshing_with(faces);
        if (leaves_out_) --remeshing.levels;
        remeshing.threads = threads;
        remeshing.progress = {};
        return try_out(input_, remesh(input_.mesh(), remeshing), silent);
    }

 private:
    /// Of a base that shows something at the least size, where this one does not but a step smaller reaches it; else 0.
    [[nodiscard]] double faces_that_fit(const Trial& trial, double faces) const {
        if (!trial.draft || trial.shows_early) return 0;
        const double share = std::pow(kFits * least_beginning(input_) / trial.draft->base_bytes(), 1 / kBytesPower);
        return share * kBaseFactor >= 1 ? share * faces : 0;
    }
    /// Levels of a file over a base of so many faces; -1: as many as remeshing finds right.
    [[nodiscard]] int levels_with(double faces) const {
        const double most_vertices = std::max(kFewVertices, kMostGrowth * double(input_.mesh().positions.size()));
        const bool larger = faces > base_, keeps = !larger || faces * std::pow(4, levels_) / 2 <= most_vertices;
        if (leaves_out_) return static_cast<int>(keeps ? levels_ : levels_ - 1);  // trials must know which is left out
        return larger && keeps && same_levels_ ? static_cast<int>(levels_) : -1;
    }
    [[nodiscard]] bool is_better(const Trial& trial, const Trial& than) const {
        const double most_loss = trial.shows_early && !than.shows_early ? kMostLossToShow : kMostLoss;
        return trial.draft && trial.remeshing_error <= most_loss * error_ && trial.score >= than.score + kLeastGain;
    }

    EncoderInput& input_;
    const EncodeOptions& options_;
    const RemeshResult& first_;
    const unsigned base_, levels_;
    const bool same_levels_, sharp_, leaves_out_;
    double error_ = 0;  // of remeshing by default, or what is small
    double best_faces_ = 0;
};

bool tries_bases(const EncoderInput& input, const RemeshResult& first, const EncodeOptions& options, bool leaves_out) {
    const bool chosen = options.base_faces > 0 || options.levels >= 0 || options.target_error > 0;
    const auto is_remeshed = [](PartOrigin origin) { return origin == PartOrigin::Remeshed; };
    return !chosen && std::ranges::all_of(first.origins, is_remeshed) && (has_same_levels(first) || !leaves_out) &&
           input.mesh().positions.size() <= kMostToTry;
}

/// The best trial of a model, and how the file is then remeshed: `first` where no other base is better.
Trial run_trials(EncoderInput& input, const EncodeOptions& options, bool leaves_out, RemeshResult& first) {
    const bool lazy = tries_lazy(input, first, options);
    constexpr TransformKind kLazy = TransformKind::SeededNormalLazy;
    if (!tries_bases(input, first, options, leaves_out)) {
        const auto trial = [&](TransformKind transform) {
            return try_out(input, leaves_out ? coarser(first) : first, with(options, transform, options.threads));
        };
        Trial best = trial(options.transform.kind);
        return lazy ? better_transform(std::move(best), trial(kLazy)) : std::move(best);
    }
    BaseTrials trials(input, first, options);
    Trial best = trials.run();
    const double faces = trials.best_faces();
    if (lazy) best = better_transform(std::move(best), trials.trial(faces, kLazy, options.threads));
    if (leaves_out && !trials.is_first(faces)) first = remesh(input.mesh(), trials.remeshing_with(faces));
    return best;
}

}  // namespace

RemeshOptions remeshing_of(const EncodeOptions& options) {
    RemeshOptions remeshing;
    remeshing.base_faces = options.base_faces;
    remeshing.levels = options.levels;
    remeshing.target_error = options.target_error;
    remeshing.threads = options.threads;
    remeshing.progress = options.progress;
    return remeshing;
}

Result<Draft> best_draft(EncoderInput& input, const EncodeOptions& options) {
    const auto report = [&](double done) {
        if (options.progress) options.progress("choose", done);
    };
    RemeshResult remeshed = remesh(input.mesh(), remeshing_of(options));
    if (std::ranges::find(remeshed.origins, PartOrigin::Remeshed) == remeshed.origins.end())
        return Draft::make(input, std::move(remeshed), options);
    report(0);
    const bool leaves_out = leaves_out_a_level(remeshed);
    Trial best = run_trials(input, options, leaves_out, remeshed);
    if (!best.draft) return Draft::make(input, std::move(remeshed), options);  // says why
    report(0.7);
    const BaseGrid grid = best.draft->best_grid(options.threads);
    report(1);
    if (leaves_out) {
        EncodeOptions as_tried = options;
        as_tried.transform.kind = best.transform;
        best.draft.reset();  // memory
        return Draft::make(input, std::move(remeshed), as_tried, grid);
    }
    if (const Result<void> r = best.draft->lay_bases(grid, options.threads); !r.ok()) return r.error();
    return std::move(*best.draft);
}

}  // namespace mvw
