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
constexpr unsigned kLeastTrialLevels = 2;
constexpr double kLeastGain = 0.1;    // dB; less is chance
constexpr double kMostLoss = 1.3;     // of the remeshing error, against that of the first base, ...
constexpr double kSmallError = 6e-5;  // ... or what is small of the diagonal
constexpr double kFailed = -std::numeric_limits<double>::infinity();

unsigned levels_of_trial(unsigned levels) {
    return levels > kLeastTrialLevels ? levels - 1 : levels;
}

/// A draft and what it measured; none where it could not be coded.
struct Trial {
    std::optional<Draft> draft;
    TransformKind transform;
    double score = kFailed, remeshing_error = 0;

    [[nodiscard]] double score_beyond_bases() const { return draft ? draft->score_beyond_bases() : kFailed; }
    [[nodiscard]] BaseGrid best_grid() const { return draft ? draft->best_grid() : BaseGrid{}; }
};

Trial try_out(EncoderInput& input, RemeshResult remeshed, TransformKind transform, EncodeOptions options,
              unsigned threads) {
    options.transform.kind = transform;
    options.threads = threads;
    options.progress = {};
    Trial trial{{}, transform};
    Result<Draft> draft = Draft::make(input, std::move(remeshed), options);
    if (!draft.ok()) return trial;
    trial.draft = std::move(*draft);
    trial.score = trial.draft->score();
    trial.remeshing_error = trial.draft->remeshing_error();
    return trial;
}

bool tries_lazy(const EncoderInput& input, const RemeshResult& first, const EncodeOptions& options) {
    const auto is_sharp = [](const SemiRegularMesh& part) { return !part.creases.empty(); };
    return options.choose_transform && options.transform.kind == TransformKind::SeededNormal &&
           input.mesh().positions.size() <= kMostToTry && std::ranges::any_of(first.parts, is_sharp);
}

/// The one without lifting unless it is worse.
Trial better_transform(Trial lifted, Trial lazy) {
    return lazy.score_beyond_bases() > lifted.score_beyond_bases() - kLeastGain ? std::move(lazy) : std::move(lifted);
}

/// Trials of a model of one part with several bases.
class BaseTrials {
 public:
    BaseTrials(EncoderInput& input, const RemeshResult& first, const EncodeOptions& options)
        : input_(input),
          options_(options),
          feature_angle_deg_(first.feature_angle_deg),
          base_(first.parts[0].base.face_count()),
          levels_(first.parts[0].levels),
          sharp_(!first.parts[0].creases.empty()) {}

    /// The best base's trial; best_steps() says which that is.
    Trial run() {
        std::optional<Trial> first, second;
        side_by_side(
            options_.threads,  //
            [&](unsigned threads) { first = trial(0, options_.transform.kind, threads); },
            [&](unsigned threads) { second = trial(1, options_.transform.kind, threads); });
        most_error_ = kMostLoss * std::max(first->remeshing_error, kSmallError);
        const bool onwards = is_better(*second, *first);
        const int next = onwards ? 2 : -1;
        Trial best = std::move(onwards ? *second : *first);
        Trial third = trial(next, options_.transform.kind, options_.threads);
        const bool takes_third = is_better(third, best);
        best_steps_ = takes_third ? next : onwards ? 1 : 0;
        return takes_third ? std::move(third) : std::move(best);
    }
    [[nodiscard]] int best_steps() const { return best_steps_; }

    /// How a file with a base so many steps from the first one is remeshed.
    [[nodiscard]] RemeshOptions remeshing_at(int steps) const {
        RemeshOptions remeshing = remeshing_of(options_);
        remeshing.feature_angle_deg = feature_angle_deg_;
        if (steps == 0) return remeshing;
        const double faces = base_ * std::pow(sharp_ ? kBaseFactor : 1 / kBaseFactor, steps);
        const double most_vertices = std::max(kFewVertices, kMostGrowth * double(input_.mesh().positions.size()));
        const bool keeps_levels = faces > base_ && faces * std::pow(4, levels_) / 2 <= most_vertices;
        remeshing.base_faces = static_cast<unsigned>(faces);
        remeshing.levels = keeps_levels ? static_cast<int>(levels_) : -1;
        return remeshing;
    }
    [[nodiscard]] Trial trial(int steps, TransformKind transform, unsigned threads) const {
        RemeshOptions remeshing = remeshing_at(steps);
        remeshing.levels = static_cast<int>(levels_of_trial(levels_));
        remeshing.threads = threads;
        remeshing.progress = {};
        return try_out(input_, remesh(input_.mesh(), remeshing), transform, options_, threads);
    }

 private:
    [[nodiscard]] bool is_better(const Trial& trial, const Trial& than) const {
        return trial.remeshing_error <= most_error_ && trial.score >= than.score + kLeastGain;
    }

    EncoderInput& input_;
    const EncodeOptions& options_;
    const double feature_angle_deg_;
    const unsigned base_, levels_;
    const bool sharp_;
    double most_error_ = 0;
    int best_steps_ = 0;
};

/// Whether other bases can be tried.
bool tries_bases(const EncoderInput& input, const RemeshResult& first, const EncodeOptions& options) {
    const bool chosen = options.base_faces > 0 || options.levels >= 0 || options.target_error > 0;
    return !chosen && first.parts.size() == 1 && first.origins[0] == PartOrigin::Remeshed &&
           input.mesh().positions.size() <= kMostToTry;
}

/// The same without the finest level of most parts.
RemeshResult coarser(RemeshResult remeshed) {
    for (SemiRegularMesh& part : remeshed.parts) {
        part.levels = levels_of_trial(part.levels);
        const auto V = static_cast<std::size_t>(vertices_at_level(part.base, part.levels));
        part.positions.resize(V);
        if (!part.colors.empty()) part.colors.resize(V);
        for (VertexField& field : part.fields) field.values.resize(V * field.components());
    }
    return remeshed;
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

Way choose_way(EncoderInput& input, const RemeshResult& first, const EncodeOptions& options) {
    const auto report = [&](double done) {
        if (options.progress) options.progress("choose", done);
    };
    Way way{remeshing_of(options), true, options.transform.kind, {}};
    if (std::ranges::find(first.origins, PartOrigin::Remeshed) == first.origins.end()) return way;
    report(0);
    Trial best;
    if (tries_bases(input, first, options)) {
        BaseTrials trials(input, first, options);
        best = trials.run();
        const int steps = trials.best_steps();
        way.remeshing = trials.remeshing_at(steps);
        way.as_first = steps == 0;
        report(0.5);
        if (tries_lazy(input, first, options))
            best = better_transform(std::move(best),
                                    trials.trial(steps, TransformKind::SeededNormalLazy, options.threads));
    } else {
        const RemeshResult remeshed = coarser(first);
        best = try_out(input, remeshed, options.transform.kind, options, options.threads);
        report(0.5);
        if (tries_lazy(input, first, options))
            best = better_transform(
                std::move(best), try_out(input, remeshed, TransformKind::SeededNormalLazy, options, options.threads));
    }
    report(0.75);
    way.transform = best.transform;
    way.grid = best.best_grid();
    report(1);
    return way;
}

}  // namespace mvw
