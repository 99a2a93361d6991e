#include "tools/bench/network.h"

#include <utility>  // before Asio, which uses std::exchange without it

#include <draco/compression/decode.h>
#include <fmt/core.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "client/client.h"
#include "codec/measure/surface_error.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/io/mesh_io.h"
#include "server/server.h"
#include "tools/bench/lod_hull.h"
#include "tools/bench/plot.h"
#include "tools/bench/process.h"
#include "tools/bench/shaper.h"

namespace mvw::bench {
namespace {

namespace fs = std::filesystem;
namespace asio = boost::asio;
using asio::ip::tcp;

constexpr double kGoodPsnr = 60, kAnyPsnr = -1000;
constexpr double kFacets = 1;  // decibels that facets of a level take from what is stated for the finest, at most
constexpr double kPlotMegabits = 5;
constexpr int kPlotRoundTrip = 100;

/// What came over one link, as time went by.
struct Arrival {
    double seconds = 0, psnr = 0;
};
struct Run {
    std::vector<Arrival> arrivals;
    std::uint64_t first_bytes = 0;  // until the first mesh
    [[nodiscard]] std::optional<double> seconds_to(double psnr) const {
        for (const Arrival& a : arrivals)
            if (a.psnr >= psnr) return a.seconds;
        return std::nullopt;
    }
};

/// How near streamed meshes are to the input, measured once for each number of bytes and level.
class Meter {
 public:
    explicit Meter(const Mesh& input) : input_(input) {}
    double psnr_of(const Mesh& mesh, std::uint64_t bytes, unsigned level) {
        const auto [known, is_new] = known_.try_emplace({bytes, level}, 0);
        if (is_new) known->second = input_.error_of(mesh, {.samples = 200'000}).psnr;
        return known->second;
    }

 private:
    ReferenceSurface input_;
    std::map<std::pair<std::uint64_t, unsigned>, double> known_;
};

Result<Run> stream(const protocol::HostPort& server, const std::string& model, const LinkShape& shape, Meter& meter) {
    auto shaper = Shaper::start(server, shape);
    if (!shaper) return shaper.error();
    struct Made {
        double seconds;
        std::uint64_t bytes;
        unsigned level;
        Mesh mesh;
    };
    std::vector<Made> made;
    int hopeful = 0;
    const auto begun = std::chrono::steady_clock::now();
    client::Callbacks callbacks;
    // Counted once a mesh is made: of the base, of what is stated to be good, and whenever nothing more waits.
    callbacks.refined = [&](const client::Refinement& r, const Decoder& decoder) {
        const double stated = r.state.error > 0 ? -20 * std::log10(r.state.error) : 200;
        const bool is_hopeful = stated >= kGoodPsnr + kFacets && ++hopeful <= 2;
        if (r.waiting > 0 && !made.empty() && !is_hopeful) return;
        const unsigned level = r.state.level + (is_hopeful || made.empty() ? 0 : 1);
        Result<Mesh> mesh = decoder.mesh(level);
        if (!mesh) return;
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begun;
        made.push_back({seconds.count(), r.state.bytes, level, std::move(mesh).value()});
    };
    client::Stream stream({client::Scheme::Tcp, (*shaper)->address(), model, false, {}}, {}, callbacks);
    const auto summary = stream.wait();
    if (!summary) return summary.error();
    Run run;
    if (!made.empty()) run.first_bytes = made.front().bytes;
    for (const Made& m : made) run.arrivals.push_back({m.seconds, meter.psnr_of(m.mesh, m.bytes, m.level)});
    return run;
}

// What a client of Draco files does before it can show them; nothing is made of the mesh.
bool decode_draco(const std::string& coded) {
    draco::DecoderBuffer buffer;
    buffer.Init(coded.data(), coded.size());
    draco::Decoder decoder;
    return decoder.DecodeMeshFromBuffer(&buffer).ok();
}

/// Reads answers one after the other from a socket; blocking.
class AnswerReader {
 public:
    explicit AnswerReader(tcp::socket& socket) : socket_(socket) {}
    /// The body of the next answer. Io where it is not a 200 or the connection ends.
    Result<std::string> next_body() {
        constexpr std::string_view kLength = "Content-Length: ";
        std::size_t end = 0;
        while ((end = text_.find("\r\n\r\n")) == std::string::npos)
            if (!more()) return Error{Errc::Io, 0, "the connection ended"};
        const std::size_t at = text_.find(kLength);
        std::size_t length = 0;
        if (!text_.starts_with("HTTP/1.1 200") || at > end) return Error{Errc::Io, 0, text_.substr(0, end)};
        std::from_chars(text_.data() + at + kLength.size(), text_.data() + end, length);
        while (text_.size() < end + 4 + length)
            if (!more()) return Error{Errc::Io, 0, "the connection ended"};
        std::string body = text_.substr(end + 4, length);
        text_.erase(0, end + 4 + length);
        return body;
    }

 private:
    bool more() {
        std::array<char, 16384> piece;
        boost::system::error_code error;
        const std::size_t n = socket_.read_some(asio::buffer(piece), error);
        text_.append(piece.data(), n);
        return !error;
    }
    tcp::socket& socket_;
    std::string text_;
};

// All files of the chain, asked for at once.
Result<Run> download(const protocol::HostPort& server, const std::vector<LodFile>& files, const LinkShape& shape) {
    auto shaper = Shaper::start(server, shape);
    if (!shaper) return shaper.error();
    const auto begun = std::chrono::steady_clock::now();
    asio::io_context io;
    tcp::socket socket(io);
    boost::system::error_code error;
    socket.connect({asio::ip::make_address("127.0.0.1"), (*shaper)->address().port}, error);
    std::string requests;
    for (const LodFile& f : files)
        requests += "GET /" + fs::path(f.path).filename().string() + " HTTP/1.1\r\nHost: h\r\n\r\n";
    if (!error) asio::write(socket, asio::buffer(requests), error);
    if (error) return Error{Errc::Io, 0, "cannot reach the shaper: " + error.message()};
    AnswerReader reader(socket);
    Run run;
    for (const LodFile& f : files) {
        const Result<std::string> body = reader.next_body();
        if (!body) return body.error();
        if (!decode_draco(*body)) return Error{Errc::Malformed, 0, f.path + ": not a Draco file"};
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begun;
        run.arrivals.push_back({seconds.count(), f.psnr});
    }
    return run;
}

/// Several runs of each over one link.
struct Case {
    std::vector<Run> ours, chain, whole;
};

// The median, as neighbours on the machine disturb; nothing where half of the runs never come so far.
std::optional<double> median_seconds(const std::vector<Run>& runs, double psnr) {
    std::vector<double> seconds;
    for (const Run& run : runs)
        if (const auto s = run.seconds_to(psnr)) seconds.push_back(*s);
    if (2 * seconds.size() < runs.size()) return std::nullopt;
    std::sort(seconds.begin(), seconds.end());
    return seconds[seconds.size() / 2];
}

std::string seconds_or_dash(const std::optional<double>& seconds) {
    return seconds ? fmt::format("{:.3f}", *seconds) : "-";
}

void add_row(Table& table, const std::string& name, double megabits, int round_trip_ms, std::uint64_t draco_bytes,
             const Case& c) {
    const double round_trip = round_trip_ms / 1000.0, rate = megabits * 1e6 / 8;
    const double first = median_seconds(c.ours, kAnyPsnr).value_or(0);
    const double first_aim = 2 * round_trip + static_cast<double>(c.ours.front().first_bytes) / rate + 0.1;
    const auto good = median_seconds(c.ours, kGoodPsnr), good_chain = median_seconds(c.chain, kGoodPsnr);
    const double draco = median_seconds(c.whole, kAnyPsnr).value_or(0);
    const bool is_long = static_cast<double>(draco_bytes) / rate > 5 * round_trip;
    const double good_aim = is_long ? draco / 3 : draco;
    table.rows.push_back({name, fmt::format("{:g}", megabits), std::to_string(round_trip_ms),
                          fmt::format("{:.3f}", first), fmt::format("{:.3f}", first_aim),
                          first <= first_aim ? "yes" : "no", seconds_or_dash(good), seconds_or_dash(good_chain),
                          fmt::format("{:.3f}", draco), fmt::format("{:.3f}", good_aim),
                          good && *good <= good_aim ? "yes" : "no"});
}

Curve curve_of(const std::string& name, const Run& run) {
    Curve curve{name, {}};
    double best = 0;
    for (const Arrival& a : run.arrivals) {
        if (best > 0) curve.points.push_back({a.seconds, best});  // a step: nothing better until now
        best = std::max(best, a.psnr);
        curve.points.push_back({a.seconds, best});
    }
    return curve;
}

class Bench {
 public:
    explicit Bench(const NetworkOptions& options) : options_(options), scratch_(options.out + "/scratch") {}

    Result<Table> run() {
        std::error_code error;
        fs::create_directories(scratch_, error);
        if (error) return Error{Errc::Io, 0, scratch_ + ": " + error.message()};
        for (const std::string& file : options_.meshes)
            if (Result<void> r = add_mesh(file); !r) return Error{r.error().code, 0, file + ": " + r.error().message};
        fs::remove_all(scratch_, error);
        return table_;
    }

 private:
    Result<void> add_mesh(const std::string& file) {
        CleanReport report;
        auto read = read_mesh(file, report);
        if (!read) return read.error();
        const Mesh mesh = normalised(clean(std::move(read).value(), report));
        const std::string name = fs::path(file).stem().string();
        const auto chain = draco_chain(mesh, options_.simplifier, scratch_);
        if (!chain) return chain.error();
        const std::string input = scratch_ + "/input.ply", coded = scratch_ + "/model.mvw";
        if (auto written = write_mesh(input, mesh); !written) return written.error();
        const auto encoded = run_process({own_program(), "encode", input, coded});
        if (!encoded || encoded->exit_code != 0) return Error{Errc::Io, 0, "mvw encode fails"};
        server::ServerOptions server_options;
        server_options.folder = server_options.page = scratch_;
        server_options.tcp.port = server_options.http.port = 0;
        const auto server = server::Server::start(server_options);
        if (!server) return server.error();
        Meter meter(mesh);
        for (const double megabits : options_.megabits)
            for (const int round_trip : options_.round_trips_ms)
                if (Result<void> r = add_case(**server, name, *chain, meter, megabits, round_trip); !r)
                    return r.error();
        return write_table();
    }

    Result<void> add_case(const server::Server& server, const std::string& name, const std::vector<LodFile>& chain,
                          Meter& meter, double megabits, int round_trip) {
        const LinkShape shape{.megabits_per_second = megabits, .round_trip = std::chrono::milliseconds(round_trip)};
        Case c;
        for (std::size_t i = 0; i < options_.runs; ++i) {
            auto ours = stream(server.tcp_address(), "model", shape, meter);
            if (!ours) return ours.error();
            auto all = download(server.http_address(), chain, shape);
            if (!all) return all.error();
            auto whole = download(server.http_address(), {chain.back()}, shape);
            if (!whole) return whole.error();
            c.ours.push_back(std::move(ours).value());
            c.chain.push_back(std::move(all).value());
            c.whole.push_back(std::move(whole).value());
        }
        add_row(table_, name, megabits, round_trip, chain.back().bytes, c);
        if (options_.say) options_.say(fmt::format("{}: {} Mbit/s, {} ms", name, megabits, round_trip));
        if (megabits != kPlotMegabits || round_trip != kPlotRoundTrip) return {};
        const Plot plot{fmt::format("{}, {:g} Mbit/s, {} ms", name, megabits, round_trip),
                        "seconds",
                        "PSNR, dB",
                        {curve_of("mvw", c.ours.front()), curve_of("chain of Draco files", c.chain.front()),
                         curve_of("whole Draco file", c.whole.front())}};
        return write_text_file(options_.out + "/" + name + ".svg", plot.svg());
    }

    Result<void> write_table() const {
        if (auto w = write_text_file(options_.out + "/network.csv", table_.csv()); !w) return w;
        return write_text_file(options_.out + "/network.md", table_.markdown());
    }

    const NetworkOptions& options_;
    const std::string scratch_;
    Table table_{{"model", "Mbit/s", "RTT ms", "first mesh s", "aim s", "met", "60 dB s", "chain 60 dB s",
                  "whole Draco s", "60 dB aim s", "60 dB met"},
                 {}};
};

}  // namespace

Result<Table> run_network(const NetworkOptions& options) {
    return Bench(options).run();
}

}  // namespace mvw::bench
