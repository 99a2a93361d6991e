// What a server counts, for /metrics.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <string>

namespace mvw::server {

/// Ways in, as metrics label them.
enum class Way : std::uint8_t { Tcp, Http, WebSocket };
inline constexpr std::size_t kWays = 3;
const char* name_of(Way way);

/// Counters and gauges of one server; all may be changed from any thread.
struct Metrics {
    using Count = std::atomic<std::uint64_t>;
    std::array<Count, kWays> opened{}, closed{};  // connections; what is open is the difference
    std::array<Count, kWays> bytes_sent{};        // as handed to the carrier
    std::array<Count, 600> http_answers{};        // by status
    Count refused{};                              // connections over a limit
    Count requests{};                             // of the native protocol
    Count chunks{};
    Count protocol_errors{};  // ERROR messages and read failures
    Count malformed{};        // connections ended by what the peer sent: HTTP or native
    Count timeouts{};         // connections ended by a timer
    Count forbidden{};        // tokens refused
    Count reload_failures{};  // unsound files met
    Count origin_requests{};  // to the HTTP store behind this server
    Count origin_failures{};  // of those, without an answer
    Count origin_bytes{};     // that came from it

    /// Prometheus text format 0.0.4.
    [[nodiscard]] std::string text(std::size_t models, double uptime_seconds) const;
};

}  // namespace mvw::server
