#include "server/metrics.h"

#include <fmt/format.h>

#include <iterator>

namespace mvw::server {
namespace {

class Writer {
 public:
    void family(const char* name, const char* type, const char* help) {
        fmt::format_to(std::back_inserter(out_), "# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
    }
    void value(const char* name, const std::string& labels, double v) {
        fmt::format_to(std::back_inserter(out_), "{}{} {}\n", name, labels.empty() ? "" : "{" + labels + "}", v);
    }
    void single(const char* name, const char* type, const char* help, double v) {
        family(name, type, help);
        value(name, "", v);
    }
    std::string take() { return std::move(out_); }

 private:
    std::string out_;
};

double number(std::uint64_t n) {
    return static_cast<double>(n);
}

}  // namespace

const char* name_of(Way way) {
    constexpr const char* kNames[kWays] = {"tcp", "http", "websocket"};
    return kNames[static_cast<std::size_t>(way)];
}

std::string Metrics::text(std::size_t models, double uptime_seconds) const {
    Writer w;
    const auto each_way = [&](const char* name, const char* type, const char* help, const auto& get) {
        w.family(name, type, help);
        for (std::size_t i = 0; i < kWays; ++i)
            w.value(name, fmt::format("transport=\"{}\"", name_of(static_cast<Way>(i))), number(get(i)));
    };
    each_way("mvw_connections_total", "counter", "Connections accepted.",
             [&](std::size_t i) { return opened[i].load(); });
    each_way("mvw_connections", "gauge", "Connections open.", [&](std::size_t i) {
        const std::uint64_t gone = closed[i].load();  // first: never more than opened
        return opened[i].load() - gone;
    });
    each_way("mvw_sent_bytes_total", "counter", "Bytes sent, before TLS.",
             [&](std::size_t i) { return bytes_sent[i].load(); });
    w.family("mvw_http_answers_total", "counter", "HTTP answers by status.");
    for (std::size_t status = 0; status < http_answers.size(); ++status)
        if (const std::uint64_t n = http_answers[status]; n > 0)
            w.value("mvw_http_answers_total", fmt::format("status=\"{}\"", status), number(n));
    w.single("mvw_refused_connections_total", "counter", "Connections over a limit.", number(refused));
    w.single("mvw_requests_total", "counter", "Requests of the native protocol.", number(requests));
    w.single("mvw_chunks_total", "counter", "Chunks sent by the native protocol.", number(chunks));
    w.single("mvw_protocol_errors_total", "counter", "Errors of the native protocol.", number(protocol_errors));
    w.single("mvw_malformed_total", "counter", "Connections ended by malformed or oversized input.", number(malformed));
    w.single("mvw_timeouts_total", "counter", "Connections ended by a timer.", number(timeouts));
    w.single("mvw_forbidden_total", "counter", "Requests refused for their token.", number(forbidden));
    w.single("mvw_unsound_models_total", "counter", "Times that a model's file was met unsound.",
             number(reload_failures));
    w.single("mvw_origin_requests_total", "counter", "Requests to the HTTP store behind this server.",
             number(origin_requests));
    w.single("mvw_origin_failures_total", "counter", "Requests that it did not answer.", number(origin_failures));
    w.single("mvw_origin_bytes_total", "counter", "Bytes of files that came from it.", number(origin_bytes));
    w.single("mvw_models", "gauge", "Models in the folder.", number(models));
    w.single("mvw_uptime_seconds", "gauge", "Since the start.", uptime_seconds);
    return w.take();
}

}  // namespace mvw::server
