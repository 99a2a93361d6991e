#include "tools/bench/load.h"

#include <unistd.h>

#include <utility>  // before Asio, which uses std::exchange without it

#include <fmt/core.h>
#include <sys/resource.h>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>
#include <random>
#include <thread>

#include "server/protocol/message_stream.h"
#include "tools/bench/process.h"

namespace mvw::bench {
namespace {

namespace fs = std::filesystem;
namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

auto into(error_code& error) {
    return asio::redirect_error(asio::use_awaitable, error);
}

tcp::endpoint loopback(std::uint16_t port) {
    return {asio::ip::address_v4::loopback(), port};
}

void raise_descriptor_limit() {
    rlimit limit{};
    ::getrlimit(RLIMIT_NOFILE, &limit);
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
}

double megabytes_of(pid_t pid) {
    std::ifstream status("/proc/" + std::to_string(pid) + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmRSS:")) return std::atof(line.c_str() + 6) / 1024;
    return 0;
}

std::size_t descriptors_of(pid_t pid) {
    std::error_code error;
    const fs::directory_iterator all("/proc/" + std::to_string(pid) + "/fd", error);
    return error ? 0 : static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

/// mvw serve with limits out of the way.
struct Served {
    BackgroundProcess process;
    std::uint16_t tcp_port = 0, http_port = 0;

    static Result<Served> start(const std::string& folder) {
        auto process =
            BackgroundProcess::start({own_program(), "serve", folder, "--tcp", "127.0.0.1:0", "--http", "127.0.0.1:0",
                                      "--max-per-address", "100000", "--max-requests", "1e9", "--log", "off"});
        if (!process) return process.error();
        const std::string line = process->first_line(20);
        Served served{std::move(process).value()};
        served.tcp_port = port_after(line, "mvw://");
        served.http_port = port_after(line, "http://");
        if (served.tcp_port == 0) return Error{Errc::Io, 0, "mvw serve does not start"};
        return served;
    }
    static std::uint16_t port_after(const std::string& line, const std::string& scheme) {
        std::uint16_t port = 0;
        const std::size_t at = line.find(scheme);
        if (at == std::string::npos) return 0;
        const char* digits = line.data() + line.find(':', at + scheme.size()) + 1;
        std::from_chars(digits, line.data() + line.size(), port);
        return port;
    }
};

std::vector<std::string> models_of(const std::string& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error))
        if (entry.path().extension() == ".mvw") names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

Bytes greeting() {
    protocol::Hello hello;
    hello.max_message_bytes = 1u << 28;
    return write_message(hello);
}

Bytes greeting_and_open(const std::string& model) {
    Bytes bytes = greeting();
    const Bytes open = write_message(protocol::Open{model, "", {}, {}});
    bytes.insert(bytes.end(), open.begin(), open.end());
    return bytes;
}

// --- idle connections ---

Result<double> idle_megabytes(const Served& server, std::size_t count) {
    asio::io_context io;
    std::vector<tcp::socket> sockets;
    sockets.reserve(count);
    const double before = megabytes_of(server.process.pid());
    const Bytes hello = greeting();
    for (std::size_t i = 0; i < count; ++i) {
        error_code error;
        sockets.emplace_back(io).connect(loopback(server.tcp_port), error);
        if (!error) asio::write(sockets.back(), asio::buffer(hello), error);
        if (error) return Error{Errc::Io, 0, fmt::format("connection {}: {}", i, error.message())};
    }
    std::this_thread::sleep_for(std::chrono::seconds(1));
    return megabytes_of(server.process.pid()) - before;
}

// --- HTTP throughput ---

struct Throughput {
    std::uint64_t bytes = 0, failures = 0;
    std::vector<std::uint64_t> answers;  // of each client
    double seconds = 0;
    [[nodiscard]] double megabytes_per_second() const { return static_cast<double>(bytes) / seconds / 1e6; }
    /// What the client that got least got, of the mean; percent.
    [[nodiscard]] double least_share() const {
        const auto sum = static_cast<double>(std::accumulate(answers.begin(), answers.end(), std::uint64_t{0}));
        const auto least = static_cast<double>(*std::min_element(answers.begin(), answers.end()));
        return 100 * least * static_cast<double>(answers.size()) / std::max(1.0, sum);
    }
};

// File after file over one connection until the time is up.
asio::awaitable<void> ask_on(asio::io_context& io, std::uint16_t port, const std::vector<std::string>& paths,
                             Clock::time_point until, std::size_t client, Throughput& total) {
    tcp::socket socket(io);
    error_code error;
    co_await socket.async_connect(loopback(port), into(error));
    Bytes buffer(64u << 10);
    std::string head;
    for (std::size_t i = 0; !error && Clock::now() < until; ++i) {
        const std::string request = "GET " + paths[i % paths.size()] + " HTTP/1.1\r\nHost: h\r\n\r\n";
        co_await asio::async_write(socket, asio::buffer(request), into(error));
        head.clear();
        std::size_t end = std::string::npos, length = 0;
        while (!error && end == std::string::npos) {
            const std::size_t n = co_await socket.async_read_some(asio::buffer(buffer), into(error));
            head.append(reinterpret_cast<const char*>(buffer.data()), n);
            end = head.find("\r\n\r\n");
        }
        const std::size_t at = head.find("Content-Length: ");
        if (error || !head.starts_with("HTTP/1.1 200") || at > end) break;
        std::from_chars(head.data() + at + 16, head.data() + end, length);
        std::size_t left = length - (head.size() - end - 4);
        while (!error && left > 0) {
            const std::size_t n = co_await socket.async_read_some(asio::buffer(buffer), into(error));
            left -= std::min(left, n);
        }
        if (error) break;
        total.bytes += length;
        ++total.answers[client];
    }
    if (Clock::now() < until) ++total.failures;
}

Throughput throughput(std::uint16_t port, const std::vector<std::string>& paths, const LoadOptions& options) {
    asio::io_context io;
    Throughput total;
    total.answers.resize(options.clients);
    const Clock::time_point begun = Clock::now();
    const auto until = begun + std::chrono::microseconds(static_cast<std::int64_t>(options.seconds * 1e6));
    for (std::size_t i = 0; i < options.clients; ++i)
        asio::co_spawn(
            io, [&, i] { return ask_on(io, port, paths, until, i, total); }, asio::detached);
    io.run();
    total.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
    return total;
}

// nginx with the same files, on a port that was free a moment ago.
Result<std::pair<BackgroundProcess, std::uint16_t>> start_nginx(const LoadOptions& options,
                                                                const std::string& scratch) {
    asio::io_context io;
    const std::uint16_t port = tcp::acceptor(io, loopback(0)).local_endpoint().port();
    const std::string conf = fmt::format(
        "daemon off; pid {0}/pid; error_log stderr; worker_processes auto; {1}\n"
        "events {{ worker_connections 4096; }}\n"
        "http {{ access_log off; sendfile on; tcp_nopush on; keepalive_requests 1000000000;\n"
        "client_body_temp_path {0}/b; proxy_temp_path {0}/p; fastcgi_temp_path {0}/f; uwsgi_temp_path {0}/u; "
        "scgi_temp_path {0}/s;\n"
        "server {{ listen 127.0.0.1:{2}; location /models/ {{ alias {3}/; }} }} }}\n",
        scratch, ::geteuid() == 0 ? "user root;" : "", port, fs::absolute(options.folder).string());
    if (auto w = write_text_file(scratch + "/nginx.conf", conf); !w) return w.error();
    auto nginx =
        BackgroundProcess::start({options.nginx, "-p", scratch, "-e", "stderr", "-c", scratch + "/nginx.conf"});
    if (!nginx) return nginx.error();
    for (int i = 0; i < 100; ++i) {
        error_code error;
        tcp::socket socket(io);
        socket.connect(loopback(port), error);
        if (!error) return std::pair(std::move(nginx).value(), port);
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return Error{Errc::Io, 0, options.nginx + " does not start"};
}

// --- time to the first chunk ---

asio::awaitable<void> first_chunk_on(asio::io_context& io, std::uint16_t port, const std::string& model,
                                     std::vector<double>& times) {
    const Clock::time_point begun = Clock::now();
    tcp::socket socket(io);
    error_code error;
    co_await socket.async_connect(loopback(port), into(error));
    const Bytes request = greeting_and_open(model);
    if (!error) co_await asio::async_write(socket, asio::buffer(request), into(error));
    protocol::MessageLimits limits;
    limits.max_body_bytes = 1u << 28;
    protocol::MessageStream messages(limits);
    Bytes buffer(64u << 10);
    bool first = true;
    while (!error) {
        const std::size_t n = co_await socket.async_read_some(asio::buffer(buffer), into(error));
        messages.add(ByteSpan(buffer).first(n));
        for (auto message = messages.next(); message.ok(); message = messages.next()) {
            if (std::holds_alternative<protocol::Chunk>(*message) && std::exchange(first, false))
                times.push_back(std::chrono::duration<double>(Clock::now() - begun).count());
            if (std::holds_alternative<protocol::End>(*message)) co_return;
        }
    }
}

std::vector<double> first_chunk_times(std::uint16_t port, const std::vector<std::string>& models, std::size_t streams) {
    asio::io_context io;
    std::vector<double> times;
    for (std::size_t i = 0; i < streams; ++i)
        asio::co_spawn(
            io, [&, i] { return first_chunk_on(io, port, models[i % models.size()], times); }, asio::detached);
    io.run();
    std::sort(times.begin(), times.end());
    return times;
}

// --- soak ---

// One client of a kind that `dice` chooses.
asio::awaitable<void> misbehave(asio::io_context& io, const Served& server, const std::string& model, unsigned dice) {
    tcp::socket socket(io);
    error_code error;
    const bool is_http = dice % 2 == 0;
    co_await socket.async_connect(loopback(is_http ? server.http_port : server.tcp_port), into(error));
    std::string text = "GET /models/" + model + ".mvw HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n";
    if (!is_http) {
        const Bytes request = greeting_and_open(model);
        text.assign(reinterpret_cast<const char*>(request.data()), request.size());
    }
    const unsigned kind = dice / 2 % 4;
    if (kind == 1) text.resize(dice / 8 % text.size());                                      // cut anywhere
    if (kind == 2) text[dice / 8 % text.size()] ^= static_cast<char>(1 + dice / 997 % 255);  // damaged
    if (!error) co_await asio::async_write(socket, asio::buffer(text), into(error));
    Bytes buffer(4096);
    std::size_t pieces = kind == 0 ? SIZE_MAX : dice / 64 % 4;  // vanishes after these
    asio::steady_timer timer(io, std::chrono::milliseconds(kind == 0 ? 2000 : dice % 200));
    timer.async_wait([&socket](const error_code& e) {
        error_code ignored;
        if (!e) socket.close(ignored);
    });
    while (!error && pieces-- > 0) co_await socket.async_read_some(asio::buffer(buffer), into(error));
    timer.cancel();
    co_await timer.async_wait(into(error));  // its handler has let go of the socket
}

// 64 misbehaving clients at a time.
void soak_for(const Served& server, const std::vector<std::string>& models, std::chrono::duration<double> time,
              std::minstd_rand& random) {
    const Clock::time_point until = Clock::now() + std::chrono::duration_cast<Clock::duration>(time);
    while (Clock::now() < until) {
        asio::io_context io;
        for (int i = 0; i < 64; ++i)
            asio::co_spawn(
                io,
                [&, dice = static_cast<unsigned>(random())] {
                    return misbehave(io, server, models[dice % models.size()], dice);
                },
                asio::detached);
        io.run();
    }
}

// Leaves them in order.
double median(std::vector<double>& values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

void add(Table& table, const std::string& measure, const std::string& value, const std::string& unit,
         const std::string& aim) {
    table.rows.push_back({measure, value, unit, aim});
}

Result<void> compare_throughput(const Served& server, const std::vector<std::string>& models,
                                const LoadOptions& options, Table& table) {
    std::vector<std::string> paths;
    paths.reserve(models.size());
    for (const std::string& m : models) paths.push_back("/models/" + m + ".mvw");
    std::string scratch = (fs::temp_directory_path() / "mvw_load_XXXXXX").string();
    if (::mkdtemp(scratch.data()) == nullptr) return Error{Errc::Io, 0, "no temporary folder can be made"};
    std::optional<std::pair<BackgroundProcess, std::uint16_t>> nginx;
    if (fs::exists(options.nginx)) {
        auto started = start_nginx(options, scratch);
        if (!started) return started.error();
        nginx.emplace(std::move(started).value());
    }
    // In turn, as neighbours on the machine disturb: a share is of two runs that follow each other.
    std::vector<double> ours, theirs, shares, least;
    for (std::size_t round = 0; round < options.rounds; ++round) {
        const Throughput a = throughput(server.http_port, paths, options);
        if (a.failures > 0) return Error{Errc::Io, 0, "mvw serve closed a connection under load"};
        ours.push_back(a.megabytes_per_second());
        least.push_back(a.least_share());
        if (!nginx) continue;
        theirs.push_back(throughput(nginx->second, paths, options).megabytes_per_second());
        shares.push_back(100 * ours.back() / theirs.back());
    }
    const bool has_nginx = nginx.has_value();
    nginx.reset();
    std::error_code ignored;
    fs::remove_all(scratch, ignored);
    const std::string of = fmt::format(", median of {}", options.rounds);
    add(table, "HTTP throughput" + of, fmt::format("{:.1f}", median(ours)), "MB/s", "");
    add(table, "share of the mean that the client with least gets", fmt::format("{:.1f}", median(least)), "%", "");
    if (!has_nginx) return {};
    add(table, "HTTP throughput of nginx" + of, fmt::format("{:.1f}", median(theirs)), "MB/s", "");
    add(table, "share of nginx" + of, fmt::format("{:.1f}", median(shares)), "%", "90 or more");
    add(table, "share of nginx, least and most", fmt::format("{:.1f} to {:.1f}", shares.front(), shares.back()), "%",
        "");
    return {};
}

}  // namespace

Result<Table> run_load(const LoadOptions& options) {
    raise_descriptor_limit();
    const std::vector<std::string> models = models_of(options.folder);
    if (models.empty()) return Error{Errc::InvalidArgument, 0, options.folder + ": no .mvw files in it"};
    const auto server = Served::start(options.folder);
    if (!server) return server.error();
    Table table{{"measure", "value", "unit", "aim"}, {}};
    if (Result<void> r = compare_throughput(*server, models, options, table); !r) return r.error();
    const std::vector<double> times = first_chunk_times(server->tcp_port, models, options.streams);
    if (times.size() < options.streams)
        return Error{Errc::Io, 0,
                     fmt::format("{} of {} streams got no chunk", options.streams - times.size(), options.streams)};
    add(table, fmt::format("first chunk, median of {} streams", times.size()),
        fmt::format("{:.1f}", 1000 * times[times.size() / 2]), "ms", "");
    add(table, "first chunk, p99", fmt::format("{:.1f}", 1000 * times[times.size() * 99 / 100]), "ms", "");
    const auto rested = Served::start(options.folder);  // has no memory left of what went before
    if (!rested) return rested.error();
    const auto idle = idle_megabytes(*rested, options.idle);
    if (!idle) return idle.error();
    add(table, fmt::format("memory of {} idle connections", options.idle), fmt::format("{:.1f}", *idle), "MB",
        "200 or less for 10000");
    return table;
}

Result<Table> run_soak(const SoakOptions& options) {
    raise_descriptor_limit();
    const std::vector<std::string> models = models_of(options.folder);
    if (models.empty()) return Error{Errc::InvalidArgument, 0, options.folder + ": no .mvw files in it"};
    const auto server = Served::start(options.folder);
    if (!server) return server.error();
    const pid_t pid = server->process.pid();
    Table table{{"seconds", "memory MB", "descriptors"}, {}};
    std::minstd_rand random(1);
    constexpr int kSteps = 20, kWarm = 2;
    double warm_memory = 0, memory = 0;
    std::size_t warm_descriptors = 0, descriptors = 0;
    for (int step = 1; step <= kSteps; ++step) {
        soak_for(*server, models, std::chrono::duration<double>(options.seconds / kSteps), random);
        std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // last words are read for a second
        memory = megabytes_of(pid);
        descriptors = descriptors_of(pid);
        if (memory == 0) return Error{Errc::Io, 0, "mvw serve has ended"};
        if (step == kWarm) warm_memory = memory, warm_descriptors = descriptors;
        table.rows.push_back({fmt::format("{:.0f}", options.seconds * step / kSteps), fmt::format("{:.1f}", memory),
                              std::to_string(descriptors)});
        if (options.say)
            options.say(fmt::format("{} s: {:.1f} MB, {} descriptors", table.rows.back()[0], memory, descriptors));
    }
    if (memory > 1.1 * warm_memory + 4 || descriptors > warm_descriptors + warm_descriptors / 10 + 8)
        return Error{Errc::Io, 0,
                     fmt::format("grew from {:.1f} MB and {} descriptors to {:.1f} MB and {}", warm_memory,
                                 warm_descriptors, memory, descriptors)};
    return table;
}

}  // namespace mvw::bench
