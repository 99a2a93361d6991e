// Carries sessions over TCP: moves bytes, keeps the session's timer, applies backpressure, nothing else.
#pragma once
#include <memory>
#include <string>

#include "server/limits.h"
#include "server/log.h"
#include "server/model_source.h"
#include "server/protocol/address.h"

namespace boost::asio {
class io_context;
}

namespace mvw::server {

/// What every peer of a server shares. Outlives the listener.
struct PeerContext {
    OpenModel open;  // called from several threads
    ServerLimits limits;
    Log log;
};

/// Accepts peers on one address. All calls from any thread.
class TcpListener {
 public:
    TcpListener(boost::asio::io_context& io, const PeerContext& context);
    ~TcpListener();
    TcpListener(const TcpListener&) = delete;
    TcpListener& operator=(const TcpListener&) = delete;

    /// Starts to accept; port 0 lets the system choose. Io where the address cannot be had.
    Result<protocol::HostPort> listen(const protocol::HostPort& address);
    /// No more peers; those that are there finish their request.
    void drain();
    /// Closes everything at once.
    void stop();
    [[nodiscard]] std::size_t connections() const;

 private:
    class Impl;
    std::shared_ptr<Impl> impl_;
};

}  // namespace mvw::server
