// mvw serve: a folder of .mvw files to whoever asks.
#include <fmt/core.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "server/server.h"
#include "tools/mvw/commands.h"

namespace mvw::cli {
namespace {

struct ServeArguments {
    std::string folder, tcp = "127.0.0.1:7707", http = "127.0.0.1:8080", log = "info";
    std::string page, tls_cert, tls_key, tokens;
    std::string origin, origin_list, origin_ca;
    double cache_gigabytes = 10;
    std::size_t max_connections = server::ServerLimits{}.max_connections;
    std::size_t max_per_address = server::ServerLimits{}.max_connections_per_address;
    double idle_seconds = 300, requests_per_second = server::ServerLimits{}.messages_per_second;
    unsigned threads = 0;
};

spdlog::level::level_enum spdlog_level(server::LogLevel level) {
    switch (level) {
        case server::LogLevel::Debug:
            return spdlog::level::debug;
        case server::LogLevel::Info:
            return spdlog::level::info;
        case server::LogLevel::Warning:
            break;
    }
    return spdlog::level::warn;
}

// Lines of key=value pairs on standard error, led by the time and the level in the same manner.
server::Log make_log(const std::string& level) {
    auto logger = spdlog::stderr_color_mt("serve");
    logger->set_pattern("time=%Y-%m-%dT%H:%M:%S.%e%z level=%^%l%$ %v");
    logger->set_level(spdlog::level::from_str(level));
    return [logger](server::LogLevel l, const std::string& line) { logger->log(spdlog_level(l), line); };
}

// Where the build or an installation puts the web page; empty where neither has.
std::string default_page() {
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    for (const std::filesystem::path& folder : {program / "page", program / "../share/mvw/page"})
        if (std::filesystem::is_directory(folder, error)) return folder.string();
    return {};
}

void serve(const ServeArguments& arguments) {
    server::ServerOptions options;
    options.folder = arguments.folder;
    Result<protocol::HostPort> tcp = protocol::parse_host_port(arguments.tcp);
    if (!tcp) throw Fatal{kUsage, "--tcp " + tcp.error().message};
    options.tcp = std::move(tcp).value();
    Result<protocol::HostPort> http = protocol::parse_host_port(arguments.http, protocol::kDefaultHttpPort);
    if (!http) throw Fatal{kUsage, "--http " + http.error().message};
    options.http = std::move(http).value();
    if (!arguments.origin.empty() || !arguments.origin_list.empty()) {
        options.origin.emplace();
        options.origin->url = arguments.origin;
        options.origin->list = arguments.origin_list;
        options.origin->ca_file = arguments.origin_ca;
        options.origin->cache_bytes = static_cast<std::uint64_t>(arguments.cache_gigabytes * 1e9);
    }
    options.page = arguments.page.empty() ? default_page() : arguments.page;
    options.tls_cert = arguments.tls_cert;
    options.tls_key = arguments.tls_key;
    if (!arguments.tokens.empty()) {
        Result<server::TokenKeys> keys = server::TokenKeys::read(arguments.tokens);
        if (!keys) throw Fatal{kFailure, keys.error().message};
        options.tokens = std::move(keys).value();
    }
    options.threads = arguments.threads;
    options.handle_signals = true;
    options.limits.max_connections = arguments.max_connections;
    options.limits.max_connections_per_address = arguments.max_per_address;
    options.limits.message_burst = std::max(options.limits.message_burst, 4 * arguments.requests_per_second);
    options.limits.messages_per_second = arguments.requests_per_second;
    options.limits.idle_time = std::chrono::milliseconds(static_cast<std::int64_t>(arguments.idle_seconds * 1000));
    options.log = make_log(arguments.log);
    const Result<std::unique_ptr<server::Server>> server = server::Server::start(options);
    if (!server) throw Fatal{kFailure, server.error().message};
    const char* secure = arguments.tls_cert.empty() ? "" : "s";
    fmt::print("serving {} models of {} on mvw{}://{} and http{}://{}\n", (*server)->models(), arguments.folder, secure,
               to_string((*server)->tcp_address()), secure, to_string((*server)->http_address()));
    std::fflush(stdout);
    (*server)->wait();
}

}  // namespace

void add_serve(CLI::App& app) {
    auto arguments = std::make_shared<ServeArguments>();
    CLI::App* command = app.add_subcommand("serve", "Streams every .mvw file below a folder");
    command->footer(
        "Prints one line with its addresses. The first interrupt lets present streams end, the second stops at once.\n"
        "Example: mvw serve models --tcp 0.0.0.0:7707");
    command->add_option("DIR", arguments->folder, "Folder to serve; with --origin, of its cache")->required();
    CLI::Option* origin = command->add_option(
        "--origin", arguments->origin,
        "Serves models of an HTTP store with Range: NAME is URL/NAME.mvw, with the URL's query behind it");
    command
        ->add_option("--origin-list", arguments->origin_list,
                     "The same by a file of lines \"NAME URL\" (pre-signed URLs), read again when it changes")
        ->excludes(origin);
    command->add_option("--origin-ca", arguments->origin_ca,
                        "PEM file of who signs the store's certificate; else the system's");
    command->add_option("--cache-gb", arguments->cache_gigabytes, "Gigabytes of the cache of --origin, 10^9 bytes each")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--tcp", arguments->tcp, "Address of the native protocol; port 0 lets the system choose")
        ->capture_default_str();
    command->add_option("--http", arguments->http, "Address of HTTP and WebSocket (ws://HOST:PORT/stream), likewise")
        ->capture_default_str();
    command->add_option("--page", arguments->page,
                        "Folder of the web page served at /; else page beside the program, where there is one");
    CLI::Option* cert = command->add_option(
        "--tls-cert", arguments->tls_cert, "PEM file of the certificate chain: TLS alone is spoken, on both addresses");
    CLI::Option* key = command->add_option("--tls-key", arguments->tls_key, "PEM file of its private key");
    cert->needs(key);
    key->needs(cert);
    command->add_option("--tokens", arguments->tokens,
                        "File of keys, one a line: models are for holders of tokens signed with one of them");
    command->add_option("--max-connections", arguments->max_connections, "In all")->capture_default_str();
    command->add_option("--max-per-address", arguments->max_per_address, "Connections of one address")
        ->capture_default_str();
    command->add_option("--idle", arguments->idle_seconds, "Seconds after which a silent client is closed")
        ->check(CLI::Range(1.0, 65535.0))
        ->capture_default_str();
    command
        ->add_option("--max-requests", arguments->requests_per_second,
                     "Messages or HTTP requests of one connection a second, on average")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--threads", arguments->threads, "0: one a core, at most 4")->capture_default_str();
    command->add_option("--log", arguments->log, "What is logged on standard error")
        ->check(CLI::IsMember({"info", "warning", "off"}))
        ->capture_default_str();
    command->callback([arguments] { serve(*arguments); });
}

}  // namespace mvw::cli
