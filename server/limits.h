// Every cap of the server, with its default. PROTOCOL.md 6 says how a peer meets them.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "server/protocol/messages.h"

namespace mvw::server {

/// Caps of one server. A peer over a cap gets ERROR with a code and a sentence where that can still be sent, and is
/// closed.
struct ServerLimits {
    protocol::MessageLimits message;       // of what clients send
    std::size_t max_connections = 20'000;  // in all
    std::size_t max_connections_per_address = 256;
    std::size_t max_open_models = 256;          // kept ready (index in memory, file open) beyond those in use
    std::size_t soft_queue_bytes = 256u << 10;  // unsent: no more chunks are scheduled
    std::size_t hard_queue_bytes = 64u << 10;   // unsent answers (pongs, ends): the peer is closed
    double messages_per_second = 50;            // of one connection, on average; HTTP requests likewise
    double message_burst = 200;                 // of one connection, at once
    std::chrono::milliseconds header_time{
        10'000};  // for HELLO, any message once begun, a TLS handshake, a request's head
    std::chrono::milliseconds stall_time{30'000};      // queued bytes and none of them taken
    std::chrono::milliseconds idle_time{300'000};      // nothing to send and nothing heard
    std::chrono::milliseconds http_idle_time{60'000};  // between two requests of one connection
    std::uint32_t max_http_head_bytes = 8192;          // of a request
    std::chrono::milliseconds drain_time{10'000};      // from the first signal to the end of the last stream
};

}  // namespace mvw::server
