// A network of a given speed and distance between two programs on one machine: a TCP proxy that delays, paces, stalls
// and resets, in user space and without rights.
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>

#include "codec/result.h"
#include "server/protocol/address.h"

namespace mvw::bench {

/// What every connection through the shaper meets; each has a link of its own.
struct LinkShape {
    double megabits_per_second = 0;                           // each direction; 0: as fast as it goes
    std::chrono::milliseconds round_trip{0};                  // half of it each way; the handshake takes one as well
    std::chrono::milliseconds jitter{0};                      // up to so much more for a piece, without reordering
    std::chrono::milliseconds stall_every{0}, stall_time{0};  // nothing moves for stall_time; 0: never
    std::uint64_t reset_after_bytes = 0;                      // towards the client, then a reset; 0: never
};

/// Listens on a loopback port and passes on to `target` until it is destroyed.
///
/// The kernel accepts a client's connection before the proxy sees it, so the delay of the handshake is made up for: all
/// that the client sends first is held back for a whole round trip more, as if its SYN had taken one. What is not
/// modelled: TCP's own slow start over the distance, loss, and a queue shared by several connections.
class Shaper {
 public:
    /// Io where no port can be had.
    static Result<std::unique_ptr<Shaper>> start(const protocol::HostPort& target, const LinkShape& shape);
    ~Shaper();
    Shaper(const Shaper&) = delete;
    Shaper& operator=(const Shaper&) = delete;

    [[nodiscard]] protocol::HostPort address() const;
    /// Bytes passed on towards clients, over all connections.
    [[nodiscard]] std::uint64_t bytes_to_clients() const;
    [[nodiscard]] std::uint64_t connections() const;

 private:
    class Impl;
    explicit Shaper(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace mvw::bench
