#include "codec/enc_closing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <utility>

#include "codec/container/enc_file.h"
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
constexpr double kMostGrowthVisible = 4, kMostGrowth = 1.4;  // ... so many times more; and others
constexpr double kFinestError = 3e-6, kFinalError = 3e-5;    // RMS, that a closed file leaves at least, at most ...
constexpr double kFinalShare = 0.75;                         // ... and of what wavelets left
constexpr double kFinestErrorOfPlain = 1e-5;                 // at least, where a file is without wavelets
constexpr double kFinalDistance = 2e-4;                      // largest one, that the last version may have
// dB in the mean of all beginnings that a closed file may lose: times the share by which it is shorter, or where
// something was wrong.
constexpr double kMostLost = 0.4, kMostLostVisible = 0.5;
constexpr double kFinerGain = 0.1;                   // dB in the mean, for a finer grid than the coarsest
constexpr double kGainOfPreview = 0.5;               // likewise, for a version that is shown before the wavelets are
constexpr double kGainOfPlain = 1.5;                 // likewise, for a file without wavelets
constexpr unsigned kFewestBits = 9, kMostBits = 14;  // of the grid behind wavelets: coarser ones look rough
constexpr unsigned kMostTried = 3;                   // of these
constexpr unsigned kFewestBitsOfPlain = 7;
constexpr unsigned kBitsOfStage = 2;     // so many at least by which a version's planes refine its base's grid
constexpr double kShareOfVersion = 0.7;  // of the error at a version's end, that is the version's own
constexpr double kShareOfLast = 0.5;     // likewise, of the last one
constexpr double kMoreFaces = 1.4;       // times the faces of a version, that the next one has at least
constexpr unsigned kFinerFirst = 2;      // a file's first version comes on its grid or one finer by up to so many bits
constexpr double kAsGood = 0.995;        // times the error of what follows, that the first version has at least, ...
constexpr std::array kSteps{kSmallStep, 1.25, 1.6};  // ... and at most so many times, the least that there is
constexpr std::uint32_t kMostFacesOfFirst = 10'000;
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

/// Stages one after the other: the first chunks of each, up to where the next one's base is about as good.
struct Chain {
    bool wavelets = true;
    const Stage* first = nullptr;  // all at once: before the wavelets, or in their place
    std::vector<const Stage*> closing;
};

/// Looks for the chain that is worth most.
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
          most_plain_(std::max(most_, wavelets_ * kMostGrowth)),
          least_(least_beginning(input)) {}

    [[nodiscard]] std::optional<Chain> run();
    [[nodiscard]] double most_bytes(const Chain& chain) const { return chain.first ? most_plain_ : most_; }

 private:
    // In the place of bits: the version that files end with, behind wavelets and without these.
    static constexpr unsigned kLast = 0, kLastOfPlain = 1;

    [[nodiscard]] bool make_versions();
    [[nodiscard]] std::vector<RatedGrid> grids_behind_wavelets() const;
    [[nodiscard]] bool make_firsts();
    [[nodiscard]] double opening_error(std::size_t chunk) const;
    [[nodiscard]] double error_of_wavelets(double bytes) const;
    [[nodiscard]] bool is_much_coarser(unsigned version, unsigned than) const {
        return versions_.at(version).mesh.base.face_count() * kMoreFaces <= versions_.at(than).mesh.base.face_count();
    }
    [[nodiscard]] const Stage* first_before(double error) const;
    const Stage& stage(unsigned bits, unsigned to);
    /// Bytes of a file, and what it is worth more than the wavelets alone, in dB in the mean.
    struct Rating {
        double bytes, gain;
    };
    [[nodiscard]] Rating rate(const Chain& chain) const;
    void extend(Chain& chain, unsigned bits);
    void offer_closed(const Chain& chain);
    void offer_plain(Chain chain);
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
    std::map<std::pair<unsigned, unsigned>, Stage> stages_;
    std::vector<Stage> firsts_;
    std::optional<Chain> best_;
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

/// Versions as they come all at once. False where none is nearer to the input than wavelets of as many bytes.
bool Search::make_firsts() {
    const auto add = [&](unsigned version, unsigned bits) -> const Stage& {
        return firsts_.emplace_back(
            code_stage(input_, versions_.at(version), {bits, 0, options_.fast, options_.threads}));
    };
    bool any = false;
    for (const auto& [version, lod] : versions_) {
        if (version < kFewestBitsOfPlain || lod.mesh.base.face_count() > kMostFacesOfFirst) continue;
        const PlannedChunk& base = add(version, version + 1).chunks.front();
        const double bytes = std::max(bytes_of(base), least_);
        any = any || (bytes < wavelets_ && base.error * kSmallStep < error_of_wavelets(bytes));
    }
    if (!any) return false;
    for (const auto& [version, lod] : versions_) {
        if (version < kFewestBitsOfPlain || lod.mesh.base.face_count() > kMostFacesOfFirst) continue;
        for (unsigned finer = 0; finer <= kFinerFirst; ++finer)
            if (finer != 1) add(version, version + finer);
    }
    return true;
}

/// The shortest first stage that a base with this error may follow.
const Stage* Search::first_before(double error) const {
    for (const double step : kSteps) {
        const Stage* best = nullptr;
        for (const Stage& s : firsts_) {
            const PlannedChunk& base = s.chunks.front();
            if (base.error < kAsGood * error || base.error > step * error) continue;
            if (!best || bytes_of(base) < bytes_of(best->chunks.front())) best = &s;
        }
        if (best) return best;
    }
    return nullptr;
}

/// A base on a grid of so many bits, and planes as far as a grid of `to` bits would be.
const Stage& Search::stage(unsigned bits, unsigned to) {
    const auto found = stages_.find({bits, to});
    if (found != stages_.end()) return found->second;
    const double error = to == kLast          ? final_error_
                         : to == kLastOfPlain ? final_error_of_plain_
                                              : kShareOfVersion * grid_error_.at(to);
    Stage made = code_stage(input_, versions_.at(to), {bits, error, options_.fast, options_.threads});
    return stages_.emplace(std::pair(bits, to), std::move(made)).first->second;
}

Search::Rating Search::rate(const Chain& chain) const {
    Worth alone(least_), worth(least_);
    double shown = kNothing;
    const auto add = [&](const PlannedChunk& chunk, double error) {
        worth.add(bytes_of(chunk), shown = std::min(shown, error));
    };
    const auto until = [&](std::size_t next) {  // that closing stage's base, if there is one
        return next < chain.closing.size() ? chain.closing[next]->chunks.front().error * kSmallStep : 0;
    };
    if (chain.first) add(chain.first->chunks.front(), chain.first->chunks.front().error);
    bool goes_on = chain.wavelets;
    for (std::size_t i = 0; i < opening_.plan.size(); ++i) {
        const double error = opening_error(i);
        alone.add(bytes_of(opening_.plan[i]), error);
        if (goes_on) add(opening_.plan[i], error);
        goes_on = goes_on && shown > until(0);
    }
    for (std::size_t k = 0; k < chain.closing.size(); ++k)
        for (const PlannedChunk& c : chain.closing[k]->chunks) {
            add(c, c.error);
            if (c.error <= until(k + 1)) break;
        }
    const double bytes = worth.bytes(), end = std::max({bytes, wavelets_, 2 * least_});
    return {bytes, (worth.up_to(end) - alone.up_to(end)) / std::log(end / least_)};
}

void Search::offer_closed(const Chain& chain) {
    const auto [bytes, gain] = rate(chain);
    const double most_lost = is_visible_ ? kMostLostVisible : kMostLost * wavelets_ / bytes;
    if (bytes > most_ || gain < -most_lost) return;
    // Finer grids come later in the file, which is longer then.
    if (best_ && (gain < gain_ + kFinerGain || (!is_visible_ && bytes > wavelets_))) return;
    gain_ = gain;
    best_ = chain;
}

void Search::offer_plain(Chain chain) {
    chain.first = first_before(chain.closing.front()->chunks.front().error);
    if (!chain.first) return;
    const auto [bytes, gain] = rate(chain);
    const bool is_best_plain = best_ && !best_->wavelets;
    const double least = is_best_plain ? gain_ : std::max(gain_, 0.0) + kGainOfPlain;
    if (bytes > most_plain_ || gain < least) return;
    gain_ = gain;
    best_ = std::move(chain);
}

/// Before the wavelets of the best chain, or of those alone.
void Search::offer_previews() {
    Chain chain = best_ ? *best_ : Chain{};
    double least = (best_ ? gain_ : 0) + kGainOfPreview;
    for (const Stage& first : firsts_) {
        chain.first = &first;
        const auto [bytes, gain] = rate(chain);
        if (bytes > most_plain_ || gain < least) continue;
        gain_ = least = gain;
        best_ = chain;
    }
}

/// All chains that go on with a base on a grid of so many bits.
void Search::extend(Chain& chain, unsigned bits) {
    const unsigned last = chain.wavelets ? kLast : kLastOfPlain;
    chain.closing.push_back(&stage(bits, last));
    chain.wavelets ? offer_closed(chain) : offer_plain(chain);
    chain.closing.pop_back();
    if (firsts_.empty() || chain.closing.size() + 2 >= kMostStages) return;
    for (unsigned to = bits + kBitsOfStage; to <= kMostBits; ++to) {
        if (!versions_.contains(to) || !is_much_coarser(to, last)) continue;
        if (!chain.closing.empty() && !is_much_coarser(bits, to)) continue;
        chain.closing.push_back(&stage(bits, to));
        extend(chain, to);
        chain.closing.pop_back();
    }
}

std::optional<Chain> Search::run() {
    if (input_.mesh().faces.size() > kMostFaces || !make_versions()) return std::nullopt;
    const auto may_end_with = [&](unsigned version, double most) {
        return double(versions_.at(version).mesh.base.vertex_count()) * kBitsAtLeast / 8 <= most;
    };
    if (!make_firsts()) firsts_.clear();
    Chain closed, plain;
    if (may_end_with(kLast, most_))
        for (const RatedGrid& grid : grids_behind_wavelets()) {
            if (best_ && grid.is_large_step) break;  // only where it must be
            extend(closed, grid.bits);
        }
    plain.wavelets = false;
    if (options_.may_be_plain && !firsts_.empty() && may_end_with(kLastOfPlain, most_plain_))
        for (unsigned bits = kFewestBitsOfPlain; bits <= kMostBits; ++bits)
            if (versions_.contains(bits)) extend(plain, bits);
    if (!best_ || best_->wavelets) offer_previews();
    return best_;
}

/// Puts a chain's stages one behind the other, each cut where the next one's base is about as good.
class Assembly {
 public:
    Assembly(const EncoderInput& input, const Opening& opening, const ClosingOptions& options)
        : input_(input), opening_(opening), options_(options) {
        out_.header = opening.header;
    }

    [[nodiscard]] std::optional<Closing> run(const Chain& chain) {
        unsigned layers = chain.wavelets ? opening_.header.layers : chain.first->layers;
        for (const Stage* s : chain.closing) layers = std::max(layers, s->layers);
        out_.header.layers = static_cast<std::uint8_t>(layers);
        if (chain.wavelets) {
            add(opening_.plan, 0, opening_.header.layers);
            if (chain.first) preview(*chain.first);
        } else {
            out_.header.parts.clear();
            add(*chain.first);
            out_.plain.push_back(chain.closing.back()->part);
        }
        for (const Stage* s : chain.closing) {
            if (!cut(s->chunks.front().error)) return std::nullopt;
            add(*s);
        }
        for (PlannedChunk& c : out_.plan) c.error *= c.error;
        return std::move(out_);
    }

 private:
    void add(const Stage& stage) {
        const auto part = static_cast<std::uint16_t>(out_.header.parts.size());
        out_.header.parts.push_back(stage.info);
        add(stage.chunks, part, stage.layers);
    }
    void add(const std::vector<PlannedChunk>& chunks, std::uint16_t first_part, unsigned layers) {
        stage_begin_ = out_.plan.size();
        for (const PlannedChunk& c : chunks) {
            PlannedChunk& to = out_.plan.emplace_back(c);
            to.id.part = static_cast<std::uint16_t>(to.id.part + first_part);
            const bool has_layer = c.id.channel != Channel::Base && c.id.channel != Channel::Attributes;
            if (has_layer) to.id.layer = static_cast<std::uint8_t>(c.id.layer + out_.header.layers - layers);
        }
    }
    /// In front. What is said of its error makes it stay until the wavelets are better.
    void preview(const Stage& stage) {
        PlannedChunk base = stage.chunks.front();
        base.id.part = static_cast<std::uint16_t>(out_.header.parts.size());
        base.payload[1] = std::byte{error_to_code(base.error)};
        for (PlannedChunk& c : out_.plan) c.error = std::min(c.error, base.error);
        out_.plan.insert(out_.plan.begin(), std::move(base));
        out_.header.parts.push_back(stage.info);
        out_.header.parts.back().preview = true;
    }
    /// Ends the last stage.
    [[nodiscard]] bool cut(double base_error) {
        const auto begin = out_.plan.begin() + std::ptrdiff_t(stage_begin_);
        const std::size_t least = stage_begin_ + std::size_t(std::count_if(begin, out_.plan.end(), is_base));
        const Result<Bytes> file = write_file(out_.header, to_write(out_.plan));
        if (!file.ok()) return false;
        std::optional<Cut> cut =
            cut_before(input_, *file, out_.plan, least, base_error, !options_.fast, options_.threads);
        if (!cut) return false;
        out_.plan.resize(cut->chunks);
        if (cut->beginning) out_.plan.push_back(std::move(*cut->beginning));
        return true;
    }

    const EncoderInput& input_;
    const Opening& opening_;
    const ClosingOptions options_;
    Closing out_;
    std::size_t stage_begin_ = 0;  // in the plan, of the last stage
};

}  // namespace

std::optional<Closing> close(const EncoderInput& input, const Opening& opening, const ClosingOptions& options) {
    Search search(input, opening, options);
    const std::optional<Chain> chain = search.run();
    if (!chain) return std::nullopt;
    std::optional<Closing> closing = Assembly(input, opening, options).run(*chain);
    if (!closing || bytes_of(closing->plan) > search.most_bytes(*chain)) return std::nullopt;
    return closing;
}

}  // namespace mvw
