// A whole server in one object: a folder of .mvw files in, streams out.
#pragma once
#include <memory>
#include <string>

#include "server/limits.h"
#include "server/log.h"
#include "server/protocol/address.h"

namespace mvw::server {

struct ServerOptions {
    std::string folder;
    protocol::HostPort tcp{"127.0.0.1", protocol::kDefaultPort};  // port 0: the system chooses
    ServerLimits limits;
    unsigned threads = 0;         // 0: one a core, at most 4
    bool handle_signals = false;  // SIGINT, SIGTERM: the first drains, the second stops
    Log log;                      // empty: nothing is logged
};

/// Serves from start() until drain() or stop() has run its course. All calls from any thread.
class Server {
 public:
    /// Io where the folder cannot be read or the address cannot be had.
    static Result<std::unique_ptr<Server>> start(ServerOptions options);
    ~Server();  // stops
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// Where it listens, with the port that the system chose.
    [[nodiscard]] protocol::HostPort tcp_address() const;
    [[nodiscard]] std::size_t connections() const;
    /// Models found at the start.
    [[nodiscard]] std::size_t models() const;

    /// No more peers; present requests are finished, for limits.drain_time at most.
    void drain();
    /// Closes everything at once.
    void stop();
    /// Returns when nothing is left to do.
    void wait();

 private:
    class Impl;
    explicit Server(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace mvw::server
