#include "codec/enc_closing.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <map>
#include <span>
#include <utility>

#include "codec/container/enc_file.h"
#include "codec/enc_progressive.h"
#include "codec/enc_remeshed.h"
#include "codec/enc_stage.h"
#include "codec/enc_switch.h"
#include "codec/part_params.h"

namespace mvw {

namespace {

constexpr double kHeadAndRow = 13;       // bytes, of a chunk in the file and in its index
constexpr double kBitsAtLeast = 9;       // a vertex, that a closing part takes
constexpr double kGoodEnough = 1.78e-4;  // RMS, 75 dB: while a closing part's base comes, the picture is at least so
constexpr double kStepVisible = 1.4;     // from wavelets to what follows, if need be, where something was wrong
constexpr double kInvisible = 2.5e-5;    // RMS, 92 dB: what is better counts no more
constexpr double kNothing = 1.78e-2;     // RMS, 35 dB: what beginnings that show nothing count as
constexpr double kVisible = 2e-3;        // largest distance, or ...
constexpr double kRough = 1e-4;          // ... RMS error, of surfaces that may take more bytes, ...
constexpr double kMostGrowthVisible = 4, kMostGrowth = 1.4;  // ... so many times more; and others, ...
constexpr double kMostGrowthOfPlain = 1.6;                   // ... and where plain triangles come first
constexpr double kFinestError = 3e-6, kFinalError = 3e-5;    // RMS, that a closed file leaves at least, at most ...
constexpr double kFinalShare = 0.75;                         // ... and of what wavelets left
constexpr double kFinestErrorOfPlain = 1e-5;                 // at least, where a file is without wavelets
constexpr double kFinalDistance = 2e-4;                      // largest one, that the last version may have
// dB in the mean of all beginnings that a closed file may lose: times the share by which it is shorter, or where
// something was wrong.
constexpr double kMostLost = 0.4, kMostLostVisible = 0.5;
constexpr double kFinerGain = 0.1;                   // dB in the mean, for a finer grid than the coarsest
constexpr double kMostPreview = 0.5;                 // of the wavelets' bytes
constexpr double kGainOfPreview = 0.5;               // likewise, for a version that is shown before the wavelets are
constexpr double kGainOfPlain = 1;                   // likewise, for a file without wavelets
constexpr unsigned kFewestBits = 9, kMostBits = 14;  // of the grid behind wavelets: coarser ones look rough
constexpr unsigned kMostTried = 3;                   // of these
constexpr unsigned kFewestBitsOfPlain = 7;
constexpr double kShareOfVersion = 0.7;  // of the error at a version's end, that is the version's own
constexpr double kShareOfLast = 0.5;     // likewise, of the last one
constexpr unsigned kFinerPreview = 2;    // a preview comes on its version's grid or one finer by so many bits
constexpr std::uint32_t kMostFacesOfPreview = 10'000;
constexpr double kBytesInFront = 130;        // of a file, before the mesh of its first base
constexpr int kPointsInChunk = 6;            // of splits: each of these brings the surface nearer
constexpr std::size_t kMostFaces = 400'000;  // of the input: simplifying and coding more takes long and gains little

bool has_borders(const Mesh& mesh) {
    const std::vector<std::uint32_t>& m = mesh.materials;
    return std::adjacent_find(m.begin(), m.end(), std::not_equal_to<>()) != m.end();
}

bool is_base(const PlannedChunk& chunk) {
    return chunk.id.channel == Channel::Base;
}

double bytes_of(const PlannedChunk& chunk) {
    return kHeadAndRow + double(chunk.payload.size());
}

double bytes_of(std::span<const PlannedChunk> chunks) {
    double bytes = 0;
    for (const PlannedChunk& c : chunks) bytes += bytes_of(c);
    return bytes;
}

/// What the beginnings of a file are worth: the integral of PSNR over the logarithm of bytes, from `least` bytes on.
class Worth {
 public:
    explicit Worth(double least) : least_(least) {}
    void add(double bytes, double rms) {
        sum_ = up_to(at_ + bytes);
        at_ += bytes;
        psnr_ = -20 * std::log10(std::max(rms, kInvisible));
    }
    [[nodiscard]] double bytes() const { return at_; }
    [[nodiscard]] double up_to(double bytes) const {
        const double from = std::max(at_, least_);
        return bytes > from ? sum_ + psnr_ * std::log(bytes / from) : sum_;
    }

 private:
    double least_, at_ = 0, psnr_ = -20 * std::log10(kNothing), sum_ = 0;
};

/// A grid for the vertices, and the RMS error that it leaves.
struct RatedGrid {
    unsigned bits;
    double error;
    bool is_large_step;  // from the wavelets at their end
};

/// What a file may come to.
struct Choice {
    bool wavelets = true;
    const Stage* preview = nullptr;  // before the wavelets
    const Stage* closing = nullptr;  // behind them
    const Stage* instead = nullptr;  // without them
};

/// Looks for the choice that is worth most.
class Search {
 public:
    Search(const EncoderInput& input, const Opening& opening, const ClosingOptions& options)
        : input_(input),
          opening_(opening),
          bases_(std::ranges::count_if(opening.plan, is_base)),
          options_(options),
          final_error_(std::clamp(kFinalShare * opening.whole.rms, kFinestError, kFinalError)),
          final_error_of_plain_(std::max(final_error_, kFinestErrorOfPlain)),
          is_visible_(opening.whole.max > kVisible || opening.whole.rms > kRough),
          wavelets_(bytes_of(opening.plan)),
          most_(wavelets_ * (is_visible_                      ? kMostGrowthVisible
                             : opening.whole.rms > kInvisible ? kMostGrowth
                                                              : 1)),
          most_plain_(std::max(most_, wavelets_ * kMostGrowthOfPlain)),
          least_(least_beginning(input)) {}

    [[nodiscard]] std::optional<Choice> run();
    /// Without wavelets, where that is worth something: in the place of a best one that cannot be put together.
    [[nodiscard]] const std::optional<Choice>& plain() const { return plain_; }
    [[nodiscard]] double most_bytes(const Choice& choice) const {
        return choice.preview || choice.instead ? most_plain_ : most_;
    }

 private:
    // In the place of bits: the version that files end with, behind wavelets and without these.
    static constexpr unsigned kLast = 0, kLastOfPlain = 1;

    [[nodiscard]] bool make_versions();
    [[nodiscard]] std::vector<RatedGrid> grids_behind_wavelets() const;
    void make_previews();
    [[nodiscard]] double opening_error(std::size_t chunk) const;
    [[nodiscard]] double error_of_wavelets(double bytes) const;
    /// Bytes of a file, and what it is worth more than the wavelets alone, in dB in the mean.
    struct Rating {
        double bytes, gain;
    };
    [[nodiscard]] Rating rate(const Choice& choice) const;
    void offer_closed();
    void offer_plain();
    void offer_previews();

    const EncoderInput& input_;
    const Opening& opening_;
    const std::ptrdiff_t bases_;  // of the opening
    const ClosingOptions options_;
    const double final_error_, final_error_of_plain_;
    const bool is_visible_;
    const double wavelets_, most_, most_plain_, least_;  // bytes
    std::map<unsigned, double> grid_error_;              // of the input's vertices, by bits
    std::map<unsigned, Lod> versions_;                   // by the bits of the grid that is about as bad
    std::deque<Stage> stages_;                           // tried
    std::vector<const Stage*> previews_;
    std::optional<Progressive> progressive_;
    std::optional<Choice> best_, plain_;
    double gain_ = 0;  // of the best one
};

bool Search::make_versions() {
    std::optional<Lod> own = own_version(input_);
    if (!own) return false;
    for (unsigned b = kFewestBitsOfPlain; b <= kMostBits; ++b)
        grid_error_[b] = error_on_grid(input_, *own, b, options_.threads);
    std::vector<unsigned> bits{kLast, kLastOfPlain};
    std::vector<VersionLimit> limits{{kShareOfLast * final_error_, kFinalDistance},
                                     {kShareOfLast * final_error_of_plain_, kFinalDistance}};
    for (unsigned b = kMostBits; b >= kFewestBitsOfPlain; --b) {
        const double error = kShareOfVersion * grid_error_[b];
        if (error <= limits.back().rms) continue;
        limits.push_back({error, INFINITY});
        bits.push_back(b);
    }
    std::vector<Lod> versions = versions_of(input_, std::move(*own), limits, options_.threads);
    for (std::size_t k = 0; k < bits.size(); ++k) versions_[bits[k]] = std::move(versions[k]);
    // How far the borders of materials have moved is not measured: the last version keeps them as they are.
    if (has_borders(input_.mesh())) versions_[kLast] = versions_[kLastOfPlain] = own_version(input_).value();
    return true;
}

/// From the coarsest that is good enough on. At most the last is a large step. The first may be any.
std::vector<RatedGrid> Search::grids_behind_wavelets() const {
    const double most = is_visible_ ? kStepVisible : kSmallStep;
    std::vector<RatedGrid> grids;
    for (unsigned bits = kFewestBits; bits <= kMostBits && grids.size() < kMostTried; ++bits) {
        const double error = grid_error_.at(bits);
        const bool is_large_step = !grids.empty() && error * kSmallStep < opening_.whole.rms;
        if (is_large_step && error * most < opening_.whole.rms) break;
        if (!is_large_step && !grids.empty() && grids.back().error > kGoodEnough) grids.clear();
        grids.push_back({bits, error, is_large_step});
        if (is_large_step) break;
    }
    return grids;
}

/// RMS error once a chunk of the wavelets is there, and all before it.
double Search::opening_error(std::size_t chunk) const {
    return std::ptrdiff_t(chunk) + 1 < bases_ ? kNothing : opening_.plan[chunk].error;
}

/// RMS error that the wavelets of so many bytes leave.
double Search::error_of_wavelets(double bytes) const {
    double error = kNothing, at = 0;
    for (std::size_t i = 0; i < opening_.plan.size(); ++i) {
        at += bytes_of(opening_.plan[i]);
        if (at > bytes) break;
        error = opening_error(i);
    }
    return error;
}

/// None where no version is nearer to the input than wavelets of as many bytes.
void Search::make_previews() {
    bool any = false;
    for (const auto& [version, lod] : versions_) {
        if (version < kFewestBitsOfPlain || lod.mesh.base.face_count() > kMostFacesOfPreview) continue;
        for (const unsigned finer : {0u, kFinerPreview}) {
            const StageOptions options{version + finer, 0, options_.fast, options_.threads};
            previews_.push_back(&stages_.emplace_back(code_stage(input_, lod, options)));
            const PlannedChunk& base = previews_.back()->chunks.front();
            const double bytes = std::max(bytes_of(base), least_);
            any = any || (bytes < wavelets_ && base.error * kSmallStep < error_of_wavelets(bytes));
        }
    }
    if (!any) previews_.clear();
}

Search::Rating Search::rate(const Choice& choice) const {
    Worth alone(least_), worth(least_);
    double shown = kNothing;
    const auto add = [&](const PlannedChunk& chunk, double error) {
        const int points = chunk.id.channel == Channel::Splits ? kPointsInChunk : 1;
        const double before = shown;
        shown = std::min(shown, error);
        for (int k = 1; k <= points; ++k)
            worth.add(bytes_of(chunk) / points, before * std::pow(shown / before, double(k) / points));
    };
    for (std::size_t i = 0; choice.preview && i < choice.preview->chunks.size(); ++i)
        add(choice.preview->chunks[i], choice.preview->chunks[i].error);
    const double until = choice.closing ? choice.closing->chunks.front().error * kSmallStep : 0;
    bool goes_on = choice.wavelets;
    for (std::size_t i = 0; i < opening_.plan.size(); ++i) {
        const double error = opening_error(i);
        alone.add(bytes_of(opening_.plan[i]), error);
        if (goes_on) add(opening_.plan[i], error);
        goes_on = goes_on && shown > until;
    }
    for (const Stage* stage : {choice.closing, choice.instead})
        for (std::size_t i = 0; stage && i < stage->chunks.size(); ++i) add(stage->chunks[i], stage->chunks[i].error);
    const double bytes = worth.bytes(), end = std::max({bytes, wavelets_, 2 * least_});
    return {bytes, (worth.up_to(end) - alone.up_to(end)) / std::log(end / least_)};
}

void Search::offer_closed() {
    for (const RatedGrid& grid : grids_behind_wavelets()) {
        if (best_ && grid.is_large_step) return;  // only where it must be
        const StageOptions options{grid.bits, final_error_, options_.fast, options_.threads};
        Choice choice;
        choice.closing = &stages_.emplace_back(code_stage(input_, versions_.at(kLast), options));
        const auto [bytes, gain] = rate(choice);
        const double most_lost = is_visible_ ? kMostLostVisible : kMostLost * wavelets_ / bytes;
        if (bytes > most_ || gain < -most_lost) continue;
        // Finer grids come later in the file, which is longer then.
        if (best_ && (gain < gain_ + kFinerGain || (!is_visible_ && bytes > wavelets_))) continue;
        gain_ = gain;
        best_ = choice;
    }
}

void Search::offer_plain() {
    Choice choice;
    choice.wavelets = false;
    choice.instead = &progressive_->whole;
    const auto [bytes, gain] = rate(choice);
    if (bytes <= most_plain_ && gain > 0) plain_ = choice;
    if (bytes > most_plain_ || gain < std::max(best_ ? gain_ : 0, 0.0) + kGainOfPlain) return;
    gain_ = gain;
    best_ = choice;
}

/// Before the wavelets of the best choice, or of those alone. What grows by splits, as far as any of these.
void Search::offer_previews() {
    for (std::size_t splits = 1; progressive_ && splits + 1 < progressive_->grown.size(); ++splits)
        previews_.push_back(&stages_.emplace_back(progressive_->beginning(splits)));

    Choice choice = best_.value_or(Choice{});
    double least = (best_ ? gain_ : 0) + kGainOfPreview;
    // One as good as what ends the wavelets would leave nothing for them.
    const double until = choice.closing ? choice.closing->chunks.front().error * kStepVisible : 0;
    for (const Stage* preview : previews_) {
        if (bytes_of(preview->chunks) > kMostPreview * wavelets_ || preview->chunks.back().error <= until) continue;
        choice.preview = preview;
        const auto [bytes, gain] = rate(choice);
        if (bytes > most_plain_ || gain < least) continue;
        gain_ = least = gain;
        best_ = choice;
    }
}

std::optional<Choice> Search::run() {
    if (input_.mesh().faces.size() > kMostFaces || !make_versions()) return std::nullopt;
    const auto may_end_with = [&](unsigned version, double most) {
        return double(versions_.at(version).mesh.base.vertex_count()) * kBitsAtLeast / 8 <= most;
    };
    if (may_end_with(kLast, most_)) offer_closed();
    make_previews();
    if (!previews_.empty())
        progressive_ =
            code_progressive(input_, versions_.at(kLastOfPlain),
                             {least_ - kBytesInFront, final_error_of_plain_, options_.fast, options_.threads});
    offer_previews();
    if (options_.may_be_plain && progressive_) offer_plain();
    return best_;
}

/// Puts stages one behind the other, the wavelets cut where the closing one's base is about as good.
class Assembly {
 public:
    Assembly(const EncoderInput& input, const Opening& opening, const ClosingOptions& options)
        : input_(input), opening_(opening), options_(options) {
        out_.header = opening.header;
    }

    [[nodiscard]] std::optional<Closing> run(const Choice& choice) {
        if (choice.instead) {
            out_.header.parts = {choice.instead->info};
            out_.header.layers = static_cast<std::uint8_t>(choice.instead->layers);
            out_.plan = choice.instead->chunks;
            out_.plain.push_back(choice.instead->part);
        } else {
            const unsigned layers =
                std::max<unsigned>(opening_.header.layers, choice.closing ? choice.closing->layers : 0);
            out_.header.layers = static_cast<std::uint8_t>(layers);
            add(opening_.plan, 0, opening_.header.layers);
            if (choice.preview) preview(*choice.preview);
            if (choice.closing && !close(*choice.closing)) return std::nullopt;
        }
        for (PlannedChunk& c : out_.plan) c.error *= c.error;
        return std::move(out_);
    }

 private:
    void add(const std::vector<PlannedChunk>& chunks, std::uint16_t first_part, unsigned layers) {
        for (const PlannedChunk& c : chunks) {
            PlannedChunk& to = out_.plan.emplace_back(c);
            to.id.part = static_cast<std::uint16_t>(to.id.part + first_part);
            const bool has_layer = c.id.channel != Channel::Base && c.id.channel != Channel::Attributes;
            if (has_layer) to.id.layer = static_cast<std::uint8_t>(c.id.layer + out_.header.layers - layers);
        }
    }
    /// In front. What is said of its error makes it stay until the wavelets are better.
    void preview(const Stage& stage) {
        std::vector<PlannedChunk> chunks = stage.chunks;
        for (PlannedChunk& c : chunks) {
            c.id.part = static_cast<std::uint16_t>(out_.header.parts.size());
            c.payload[is_base(c) ? 1 : 0] = std::byte{error_to_code(c.error)};
        }
        for (PlannedChunk& c : out_.plan) c.error = std::min(c.error, chunks.back().error);
        out_.plan.insert(out_.plan.begin(), std::make_move_iterator(chunks.begin()),
                         std::make_move_iterator(chunks.end()));
        out_.header.parts.push_back(stage.info);
        out_.header.parts.back().preview = true;
    }
    /// Ends the wavelets.
    [[nodiscard]] bool close(const Stage& stage) {
        const auto last_base = std::find_if(out_.plan.rbegin(), out_.plan.rend(), is_base);
        const auto least = static_cast<std::size_t>(out_.plan.rend() - last_base);
        const Result<Bytes> file = write_file(out_.header, to_write(out_.plan));
        if (!file.ok()) return false;
        std::optional<Cut> cut =
            cut_before(input_, *file, out_.plan, least, stage.chunks.front().error, !options_.fast, options_.threads);
        if (!cut) return false;
        out_.plan.resize(cut->chunks);
        if (cut->beginning) out_.plan.push_back(std::move(*cut->beginning));
        const auto part = static_cast<std::uint16_t>(out_.header.parts.size());
        out_.header.parts.push_back(stage.info);
        add(stage.chunks, part, stage.layers);
        return true;
    }

    const EncoderInput& input_;
    const Opening& opening_;
    const ClosingOptions options_;
    Closing out_;
};

}  // namespace

std::optional<Closing> close(const EncoderInput& input, const Opening& opening, const ClosingOptions& options) {
    Search search(input, opening, options);
    const std::optional<Choice> best = search.run();
    if (!best) return std::nullopt;
    for (const std::optional<Choice>& choice : {best, search.plain()}) {
        if (!choice) continue;
        std::optional<Closing> closing = Assembly(input, opening, options).run(*choice);
        if (closing && bytes_of(closing->plan) <= search.most_bytes(*choice)) return closing;
    }
    return std::nullopt;
}

}  // namespace mvw
