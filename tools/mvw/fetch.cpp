// mvw fetch: a model from a server into a file, refining while it comes.
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "client/client.h"
#include "codec/mesh/io/files.h"
#include "codec/mesh/io/mesh_io.h"
#include "tools/mvw/commands.h"
#include "tools/mvw/load.h"

namespace mvw::cli {
namespace {

constexpr std::string_view kContainerEnding = ".mvw";

struct FetchArguments {
    std::string url, output, snapshots, token, ca_file, cache;
    std::uint64_t cache_megabytes = 1024;
    unsigned level = 255;
    std::uint64_t max_bytes = 0;
    double target_error = 0;
    bool json = false;

    [[nodiscard]] bool wants_container() const { return output.ends_with(kContainerEnding); }
};

/// One line on a terminal: how far, how fine. Written by the decoding thread, read by nobody else.
class ProgressBar {
 public:
    explicit ProgressBar(bool shown) : shown_(shown) {}
    void set_total(std::uint64_t bytes) { total_ = bytes; }
    void show(const client::Refinement& r) {
        constexpr double kEvery = 0.1;  // seconds
        if (!shown_ || (r.seconds < next_ && r.waiting > 0)) return;
        next_ = r.seconds + kEvery;
        constexpr std::size_t kWidth = 30;
        const double share = total_ == 0 ? 0 : std::min(1.0, static_cast<double>(r.state.bytes) / total_);
        const auto full = static_cast<std::size_t>(share * kWidth);
        fmt::print(stderr, "\r[{}{}] {:>10} bytes  level {:>2}  error {:.2e} ", std::string(full, '='),
                   std::string(kWidth - full, ' '), r.state.bytes, r.state.level, r.state.error);
        std::fflush(stderr);
        drawn_ = true;
    }
    /// Before other lines.
    void leave() {
        if (drawn_) fmt::print(stderr, "\n");
        drawn_ = false;
    }

 private:
    bool shown_, drawn_ = false;
    std::atomic<std::uint64_t> total_ = 0;
    double next_ = 0;
};

/// Writes a mesh and a row whenever the model has become visibly better: a new level, or half the error.
class Snapshots {
 public:
    Snapshots(const FetchArguments& arguments, std::FILE* table) : arguments_(arguments), table_(table) {
        if (!on()) return;
        std::error_code error;
        std::filesystem::create_directories(arguments.snapshots, error);
        if (error) throw Fatal{kFailure, arguments.snapshots + ": " + error.message()};
        ending_ = arguments.wants_container() ? ".ply" : std::filesystem::path(arguments.output).extension().string();
        if (table_ != nullptr)
            fmt::print(table_, "{:>10} {:>5} {:>9} {:>10} {:>8}  {}\n", "bytes", "level", "vertices", "error",
                       "seconds", "file");
    }
    [[nodiscard]] bool on() const { return !arguments_.snapshots.empty(); }

    void offer(const client::Refinement& r, const Decoder& decoder) {
        last_ = r;
        if (!on() || failure_) return;
        if (count_ > 0 && r.state.level == shown_.level && r.state.error > shown_.error / 2) return;
        take(r, decoder);
    }
    /// The last state, unless it has been taken.
    void finish(const Decoder& decoder) {
        if (on() && last_ && !failure_ && shown_.bytes != last_->state.bytes) take(*last_, decoder);
    }
    [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }

 private:
    void take(const client::Refinement& r, const Decoder& decoder) {
        const Result<Mesh> mesh = decoder.mesh(arguments_.level);
        if (!mesh) return;  // no base mesh yet
        const std::string path =
            (std::filesystem::path(arguments_.snapshots) / fmt::format("{:03}{}", count_, ending_)).string();
        if (Result<void> written = write_mesh(path, *mesh); !written) {
            failure_ = written.error();
            return;
        }
        ++count_;
        shown_ = r.state;
        if (table_ == nullptr) return;
        fmt::print(table_, "{:>10} {:>5} {:>9} {:>10.3e} {:>8.3f}  {}\n", r.state.bytes, r.state.level,
                   mesh->positions.size(), r.state.error, r.seconds, path);
        std::fflush(table_);
    }

    const FetchArguments& arguments_;
    std::FILE* table_;
    std::string ending_;
    unsigned count_ = 0;
    DecodeState shown_;
    std::optional<client::Refinement> last_;
    std::optional<Error> failure_;
};

client::StreamOptions stream_options(const FetchArguments& arguments) {
    client::StreamOptions options;
    options.wants.max_level = static_cast<std::uint8_t>(arguments.level);
    options.wants.byte_budget = arguments.max_bytes;
    options.wants.target_error = static_cast<float>(arguments.target_error);
    options.token = arguments.token;
    options.ca_file = arguments.ca_file;
    options.cache_folder = arguments.cache;
    options.cache_bytes = arguments.cache_megabytes << 20;
    options.keep_chunks = arguments.wants_container();
    return options;
}

void write_output(const FetchArguments& arguments, const client::Feed& feed, const Result<Mesh>& mesh) {
    if (arguments.wants_container()) {
        const Result<Bytes> file = feed.file();
        if (!file) throw Fatal{kFailure, arguments.url + ": " + file.error().message};
        if (Result<void> w = write_file(arguments.output, *file); !w) throw Fatal{kFailure, w.error().message};
        return;
    }
    if (!mesh) throw Fatal{kFailure, arguments.url + ": what came holds no mesh: " + mesh.error().message};
    warn_of_attributes(arguments.output, *mesh);
    if (Result<void> w = write_mesh(arguments.output, *mesh); !w) throw Fatal{kFailure, w.error().message};
}

void report(const FetchArguments& arguments, const client::Summary& summary, const DecodeState& state,
            std::size_t vertices) {
    const unsigned level = std::min(arguments.level, state.level);
    if (!arguments.json) {
        if (::isatty(STDERR_FILENO) != 0)
            fmt::print(stderr, "{} bytes, level {}, {} vertices, error {:.3e}, {:.2f} s\n", state.bytes, level,
                       vertices, state.error, summary.seconds);
        return;
    }
    nlohmann::ordered_json json{{"bytes", state.bytes},       {"level", level},
                                {"vertices", vertices},       {"error", state.error},
                                {"seconds", summary.seconds}, {"first_mesh_seconds", nullptr},
                                {"resumed", summary.resumed}};
    if (summary.first_mesh_seconds) json["first_mesh_seconds"] = *summary.first_mesh_seconds;
    fmt::print("{}\n", json.dump());
}

void fetch(const FetchArguments& arguments) {
    const Result<client::Url> url = client::parse_url(arguments.url);
    if (!url) throw Fatal{kUsage, url.error().message};
    if (!arguments.wants_container() && !can_write_mesh(arguments.output))
        throw Fatal{kUsage, arguments.output +
                                ": neither .mvw nor a kind of mesh file that is written (.ply .obj .stl .off .glb)"};

    const bool terminal = ::isatty(STDERR_FILENO) != 0;
    ProgressBar bar(terminal && arguments.snapshots.empty());
    Snapshots snapshots(arguments, arguments.json ? (terminal ? stderr : nullptr) : stdout);
    client::Callbacks callbacks;
    callbacks.refined = [&](const client::Refinement& r, const Decoder& decoder) {
        bar.show(r);
        snapshots.offer(r, decoder);
    };
    callbacks.opened = [&](const client::Opened& o) {
        const std::uint64_t all = o.header.size() + o.payload_bytes;
        bar.set_total(arguments.max_bytes == 0 ? all : std::min(all, arguments.max_bytes));
    };
    callbacks.broken = [&](const client::Broken& b) {
        fmt::print(stderr, "{}mvw: {}: {}; again in {:.1f} s\n", terminal ? "\n" : "", arguments.url, b.why.message,
                   std::chrono::duration<double>(b.retry_in).count());
    };
    callbacks.restarted = [&] {
        fmt::print(stderr, "{}mvw: {}: the model has changed on the server, beginning anew\n", terminal ? "\n" : "",
                   arguments.url);
    };

    client::Stream stream(*url, stream_options(arguments), callbacks);
    const Result<client::Summary> summary = stream.wait();
    bar.leave();
    if (!summary) throw Fatal{kFailure, arguments.url + ": " + summary.error().message};
    const Decoder& decoder = stream.feed().decoder();
    snapshots.finish(decoder);
    if (snapshots.failure()) throw Fatal{kFailure, snapshots.failure()->message};
    const Result<Mesh> mesh = decoder.mesh(arguments.level);
    write_output(arguments, stream.feed(), mesh);
    report(arguments, *summary, stream.feed().state(), mesh ? mesh->positions.size() : 0);
}

}  // namespace

void add_fetch(CLI::App& app) {
    auto arguments = std::make_shared<FetchArguments>();
    CLI::App* command = app.add_subcommand("fetch", "Streams a model from a server into a file");
    command->footer("Example: mvw fetch mvw://127.0.0.1:7707/bunny bunny.ply --target-error 1e-4");
    command
        ->add_option("URL", arguments->url,
                     "mvw://HOST[:PORT]/MODEL, ws://HOST[:PORT]/MODEL, http://HOST[:PORT]/PATH.mvw; mvws, wss, https: "
                     "the same with TLS")
        ->required();
    command->add_option("OUTPUT", arguments->output, "Mesh file, or .mvw for the chunks as received")->required();
    command->add_option("--level", arguments->level, "Finest level wanted; 0 is the base mesh")
        ->check(CLI::Range(0, 255));
    command->add_option("--max-bytes", arguments->max_bytes, "Bytes of the model to fetch at most, its header included")
        ->check(CLI::PositiveNumber);
    command
        ->add_option("--target-error", arguments->target_error,
                     "RMS error that is good enough, as a fraction of the box's diagonal")
        ->check(CLI::PositiveNumber);
    command->add_option(
        "--snapshots", arguments->snapshots,
        "Folder for a mesh of each refinement (a new level or half the error), and a table row for each");
    command->add_option("--token", arguments->token, "Access token, as mvw token prints it");
    command->add_option("--ca", arguments->ca_file,
                        "PEM file of who signs the server's certificate; else the system's are trusted");
    command->add_option("--cache", arguments->cache, "Folder that keeps chunks between runs: none is fetched twice");
    command->add_option("--cache-mb", arguments->cache_megabytes, "Size of that folder at most")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_flag("--json", arguments->json,
                      "One JSON object: bytes level vertices error seconds first_mesh_seconds resumed");
    command->callback([arguments] { fetch(*arguments); });
}

}  // namespace mvw::cli
