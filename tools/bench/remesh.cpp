#include "tools/bench/remesh.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <thread>

#include "client/viewer/picture.h"
#include "codec/enc_adapt.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/io/mesh_io.h"
#include "codec/remesh/remesh.h"
#include "tools/bench/folds.h"
#include "tools/bench/model_files.h"

namespace mvw::bench {
namespace {

constexpr unsigned kWidth = 640, kHeight = 560;
constexpr std::uint32_t kSamples = 200'000;
constexpr double kRed = 1e-3;  // of the diagonal: red in error pictures

const std::vector<std::string> kHead{"model",         "input vertices",
                                     "input faces",   "step",
                                     "base faces",    "levels",
                                     "vertices",      "dB",
                                     "max",           "folds",
                                     "input folds",   "no area",
                                     "tangential",    "median",
                                     "median normal", "topology",
                                     "alone share",   "seconds",
                                     "cpu seconds",   "seconds by phase",
                                     "peak MB",       "note"};

/// Memory's peak is counted from here on, where the system lets it.
void forget_peak() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
}

double peak_megabytes() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (double kilobytes = 0; word == "VmHWM:" && status >> kilobytes) return kilobytes / 1024;
    return 0;
}

double cpu_seconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;  // of all threads
}

/// Wall-clock seconds by phase, as the remesher reports where it is.
class Profile {
 public:
    void enter(const std::string& phase) {
        const auto now = std::chrono::steady_clock::now();
        if (!phases_.empty()) phases_.back().second += std::chrono::duration<double>(now - since_).count();
        since_ = now;
        if (phases_.empty() || phases_.back().first != phase) {
            // A phase that comes again (a finer level) goes on where it was.
            const auto known = std::ranges::find(phases_, phase, &Phase::first);
            if (known == phases_.end())
                phases_.emplace_back(phase, 0);
            else
                std::rotate(known, known + 1, phases_.end());
        }
    }
    [[nodiscard]] std::string text() const {
        std::string out;
        for (const auto& [phase, seconds] : phases_)
            if (!phase.empty()) out += fmt::format("{}{} {:.1f}", out.empty() ? "" : ", ", phase, seconds);
        return out;
    }

 private:
    using Phase = std::pair<std::string, double>;
    std::vector<Phase> phases_;
    std::chrono::steady_clock::time_point since_;
};

/// A model's remesh at one step.
struct Step {
    const char* name = "";
    std::vector<SemiRegularMesh> parts;  // in coded units
    double seconds = 0, cpu = 0, peak = 0;
    std::string profile;
};

Mesh in_model_units(const Step& step, const EncoderInput& input) {
    Mesh out = finest_mesh(step.parts);
    for (Vec3& p : out.positions) p = input.to_model_units(p);
    return out;
}

std::uint64_t count_without_area(const Mesh& mesh) {
    return static_cast<std::uint64_t>(std::ranges::count_if(mesh.faces, [&](const Face& f) {
        const Vec3& a = mesh.positions[f[0]];
        return squared_length(cross(mesh.positions[f[1]] - a, mesh.positions[f[2]] - a)) == 0;
    }));
}

/// Of each level from 2 up, over all parts: the share of the details' energy that is not along normals.
std::vector<double> tangential_shares(const std::vector<SemiRegularMesh>& parts, TransformKind kind) {
    std::vector<double> all, tangential, shares;
    TransformOptions options;
    options.kind = kind;
    for (const SemiRegularMesh& part : parts) {
        if (part.levels == 0) continue;
        std::vector<Vec3f> positions(part.positions.size()), details(part.positions.size());
        std::transform(part.positions.begin(), part.positions.end(), positions.begin(), to_float);
        PatchTransform(part.base, part.levels, options, part.creases).analyze(positions, details);
        all.resize(std::max<std::size_t>(all.size(), part.levels + 1), 0);
        tangential.resize(all.size(), 0);
        for (unsigned level = 2; level <= part.levels; ++level)
            for (std::size_t v = vertices_at_level(part.base, level - 1); v < vertices_at_level(part.base, level);
                 ++v) {
                const Vec3 d = to_double(details[v]);
                all[level] += squared_length(d);
                tangential[level] += d.y * d.y + d.z * d.z;
            }
    }
    for (std::size_t level = 2; level < all.size(); ++level)
        shares.push_back(all[level] > 0 ? tangential[level] / all[level] : 0);
    return shares;
}

std::string median_of(std::vector<double> values) {
    if (values.empty()) return "";
    std::ranges::sort(values);
    return fmt::format("{:.3f}", (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2);
}

/// The input, the remesh with its base's edges, and the remesh coloured by its distance from the input.
Result<void> draw(const Mesh& input, const Step& step, const Mesh& remeshed, const EncoderInput& coded,
                  const std::string& path) {
    PictureOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.camera = fit_camera(input, options.yaw, options.pitch, double{kWidth} / kHeight);
    PictureOptions with_lines = options;
    for (const SemiRegularMesh& part : step.parts) {
        std::vector<Vec3> positions;
        for (const Vec3& p : part.positions) positions.push_back(coded.to_model_units(p));
        for (auto& line : base_edge_lines(part.base, part.levels, positions))
            with_lines.lines.push_back(std::move(line));
    }
    Mesh errors = remeshed;
    errors.colors = heat_colors(vertex_errors(input, errors.positions), kRed);
    std::vector<SheetEntry> entries;
    const auto add = [&](const Mesh& mesh, const PictureOptions& how, std::string caption) -> Result<void> {
        auto image = draw_picture(mesh, how);
        if (!image.ok()) return image.error();
        entries.push_back({std::move(*image), std::move(caption)});
        return {};
    };
    if (auto r = add(input, options, fmt::format("input: {} vertices", input.positions.size())); !r.ok()) return r;
    if (auto r = add(remeshed, with_lines, fmt::format("remesh: {} vertices", remeshed.positions.size())); !r.ok())
        return r;
    if (auto r = add(errors, options, "blue 0, red 0.1 % of the diagonal and over"); !r.ok()) return r;
    return write_png(path, contact_sheet(entries, 3));
}

/// Both steps of one model.
class Run {
 public:
    static Result<Run> make(const std::string& file, const RemeshBenchOptions& options) {
        CleanReport report;
        auto read = read_mesh(file, report);
        if (!read.ok()) return read.error();
        Run run;
        run.mesh_ = std::make_unique<Mesh>(clean(std::move(*read), report));
        if (!measurable(*run.mesh_)) return Error{Errc::InvalidArgument, 0, file + ": no face of positive area"};
        run.input_folds_ = count_folds(*run.mesh_);
        run.topology_ = topology_of(*run.mesh_);
        forget_peak();
        run.options_.base_faces = options.base_faces;
        run.options_.levels = options.levels;
        run.options_.threads = std::max(1u, std::thread::hardware_concurrency());
        run.begin_ = Clock::now();
        run.cpu_begin_ = cpu_seconds();
        run.options_.progress = [&run](const char* phase, double) { run.profile_.enter(phase); };
        run.profile_.enter("recognize");
        run.remeshed_ = remesh(*run.mesh_, run.options_);
        run.profile_.enter("");
        run.first_ = run.step("remesh", {});
        run.options_.progress = {};
        run.transform_.kind = options.transform;
        auto input = EncoderInput::make(*run.mesh_, run.options_.threads);
        if (!input.ok()) return input.error();
        run.input_ = std::move(*input);
        for (SemiRegularMesh& part : run.remeshed_.parts)
            for (Vec3& p : part.positions) p = run.input_->to_coded_units(p);
        return run;
    }

    [[nodiscard]] Step first() const {
        Step step = first_;
        step.parts = remeshed_.parts;
        return step;
    }
    Step second() {
        std::vector<SemiRegularMesh> parts = remeshed_.parts;
        for (std::uint32_t p = 0; p < parts.size(); ++p) {
            if (remeshed_.origins[p] != PartOrigin::Remeshed) continue;
            Adaptation adaptation(input_->part(remeshed_, p), transform_, options_.threads, std::move(parts[p]));
            adaptation.slide(options_.threads);
            parts[p] = adaptation.mesh();
        }
        return step("slide", std::move(parts));
    }
    [[nodiscard]] const Mesh& mesh() const { return *mesh_; }
    [[nodiscard]] const EncoderInput& input() const { return *input_; }
    [[nodiscard]] std::uint64_t input_folds() const { return input_folds_; }
    [[nodiscard]] const Topology& topology() const { return topology_; }
    [[nodiscard]] double alone_share() const { return remeshed_.alone_area_share; }

 private:
    using Clock = std::chrono::steady_clock;
    [[nodiscard]] Step step(const char* name, std::vector<SemiRegularMesh> parts) const {
        const std::chrono::duration<double> seconds = Clock::now() - begin_;
        return {name, std::move(parts), seconds.count(), cpu_seconds() - cpu_begin_, peak_megabytes(), profile_.text()};
    }

    std::unique_ptr<Mesh> mesh_;
    std::uint64_t input_folds_ = 0;
    Topology topology_;  // of the input
    RemeshOptions options_;
    TransformOptions transform_;
    Profile profile_;
    Step first_;  // without its parts
    Clock::time_point begin_;
    double cpu_begin_ = 0;
    RemeshResult remeshed_;
    std::unique_ptr<EncoderInput> input_;
};

std::vector<std::string> row_of(const std::string& name, const Run& run, const Step& step, const Mesh& remeshed) {
    const Mesh& input = run.mesh();
    std::uint64_t base_faces = 0;
    unsigned levels = 0;
    for (const SemiRegularMesh& part : step.parts) {
        base_faces += part.base.face_count();
        levels = std::max(levels, part.levels);
    }
    const SurfaceError error = run.input().reference().error_of(remeshed, {kSamples});
    const std::vector<double> shares = tangential_shares(step.parts, TransformKind::SeededLazy);
    std::string by_level;
    for (const double share : shares) by_level += fmt::format("{}{:.3f}", by_level.empty() ? "" : " ", share);
    return {name,
            std::to_string(input.positions.size()),
            std::to_string(input.faces.size()),
            step.name,
            std::to_string(base_faces),
            std::to_string(levels),
            std::to_string(remeshed.positions.size()),
            fmt::format("{:.2f}", error.psnr),
            fmt::format("{:.2e}", error.max),
            std::to_string(count_folds(remeshed)),
            std::to_string(run.input_folds()),
            std::to_string(count_without_area(remeshed)),
            by_level,
            median_of(shares),
            median_of(tangential_shares(step.parts, TransformKind::SeededNormalLazy)),
            topology_of(remeshed) == run.topology() ? "kept" : "changed",
            fmt::format("{:.4f}", run.alone_share()),
            fmt::format("{:.1f}", step.seconds),
            fmt::format("{:.1f}", step.cpu),
            step.profile,
            fmt::format("{:.0f}", step.peak),
            ""};
}

Result<void> add_rows(const ModelFile& model, const RemeshBenchOptions& options, Table& table) {
    const auto file = unpacked(model, options.out);
    if (!file.ok()) return file.error();
    auto run = Run::make(*file, options);
    if (*file != model.file.string()) std::filesystem::remove(*file);
    if (!run.ok()) return run.error();
    const Step steps[] = {run->first(), run->second()};  // before anything is measured: they state times
    for (const Step& step : steps) {
        const Mesh remeshed = in_model_units(step, run->input());
        table.rows.push_back(row_of(model.name, *run, step, remeshed));
        if (options.say) options.say(fmt::format("{}", fmt::join(table.rows.back(), "  ")));
        if (&step != std::end(steps) - 1 || !options.pictures) continue;
        const std::string path = options.out + "/" + model.name + ".png";
        if (auto r = draw(run->mesh(), step, remeshed, run->input(), path); !r.ok()) return r;
    }
    return {};
}

}  // namespace

Result<Table> run_remesh(const RemeshBenchOptions& options) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return Error{Errc::Io, 0, options.out + ": " + error.message()};
    const auto models = list_models(options.folder, options.only);
    if (!models.ok()) return models.error();
    Table table{kHead, {}};
    for (const ModelFile& model : *models) {
        if (const Result<void> added = add_rows(model, options, table); !added.ok()) {
            table.rows.emplace_back(kHead.size());
            table.rows.back().front() = model.name;
            table.rows.back().back() = added.error().message;
        }
        // Written after each model: a run that is cut short leaves what it found.
        if (auto r = write_text_file(options.out + "/remesh.csv", table.csv()); !r.ok()) return r.error();
        if (auto r = write_text_file(options.out + "/remesh.md", table.markdown()); !r.ok()) return r.error();
    }
    return table;
}

}  // namespace mvw::bench
