// Accepts connections on one address and keeps those that are there; what they speak is their maker's matter. Inside
// the server only.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "server/limits.h"
#include "server/log.h"
#include "server/metrics.h"
#include "server/model_source.h"
#include "server/protocol/address.h"
#include "server/transport/carrier.h"
#include "server/transport/workers.h"

namespace mvw::server {

/// What every connection of a server shares. Outlives them.
struct PeerContext {
    OpenModel open;  // called from several threads, like the next two
    WhenKnown when_known;
    CheckToken allow;  // empty: all is allowed
    ServerLimits limits;
    Log log;
    Metrics& metrics;
};

/// One peer, however it speaks. All calls on its strand.
class Connection {
 public:
    virtual ~Connection() = default;
    [[nodiscard]] virtual Strand strand() = 0;
    virtual void start() = 0;
    /// What is under way is finished, nothing else begun.
    virtual void drain() = 0;
    virtual void end(const std::string& reason) = 0;
};

/// Counts connections over all listeners of a server. All calls from any thread.
class Admission {
 public:
    explicit Admission(const ServerLimits& limits) : limits_(limits) {}
    /// False where one more would be over a limit; else release() is due.
    bool admit(const asio::ip::address& from);
    void release(const asio::ip::address& from);
    [[nodiscard]] std::size_t connections() const;

 private:
    const ServerLimits& limits_;
    mutable std::mutex mutex_;
    std::size_t total_ = 0;
    std::map<asio::ip::address, std::size_t> per_address_;
};

/// Accepts peers on one address. All calls from any thread.
class Listener : public std::enable_shared_from_this<Listener> {
 public:
    /// Makes the connection of an accepted socket; `on_end` is to be called once, with its end().
    using Make =
        std::function<std::shared_ptr<Connection>(Socket socket, std::string name, std::function<void()> on_end)>;

    /// `refusal` is what a peer over a limit is told, as far as one write takes it; may be empty. `workers`, `context`
    /// and `admission` outlive the listener.
    Listener(Workers& workers, const PeerContext& context, Admission& admission, Make make, Bytes refusal);

    /// Starts to accept; port 0 lets the system choose. Io where the address cannot be had.
    Result<protocol::HostPort> listen(const protocol::HostPort& address);
    /// No more peers; those that are there finish what they do.
    void drain();
    /// Closes everything at once.
    void stop();
    /// Lets go of connections that could not be ended. Once no thread runs any more.
    void forget() { connections_.clear(); }

 private:
    asio::awaitable<void> accept_loop();
    void admit(Socket socket, const tcp::endpoint& from);
    void refuse(Socket socket);
    void release(const asio::ip::address& address, std::uint64_t key);
    void stop_accepting();

    Workers& workers_;
    Strand strand_;  // all that follows is touched on it alone once listen() has returned
    asio::basic_socket_acceptor<tcp, Strand> acceptor_;
    Timer retry_;
    const PeerContext& context_;
    Admission& admission_;
    const Make make_;
    const Bytes refusal_;
    std::uint64_t next_key_ = 0;
    std::unordered_map<std::uint64_t, std::shared_ptr<Connection>> connections_;
};

}  // namespace mvw::server
