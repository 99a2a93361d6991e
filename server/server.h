// A whole server in one object: a folder of .mvw files in, streams out by TCP, WebSocket and HTTP.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "server/limits.h"
#include "server/log.h"
#include "server/origin/origin_store.h"
#include "server/protocol/address.h"
#include "server/token.h"

namespace mvw::server {

struct ServerOptions {
    std::string folder;                                                // of models, or of `origin`'s cache
    std::optional<OriginOptions> origin;                               // models are there; its folder is the one above
    protocol::HostPort tcp{"127.0.0.1", protocol::kDefaultPort};       // port 0: the system chooses
    protocol::HostPort http{"127.0.0.1", protocol::kDefaultHttpPort};  // WebSocket as well
    std::string page;                 // folder of the web page served at "/"; empty: none
    std::string tls_cert, tls_key;    // PEM files; both or none. TLS is then spoken on both addresses, and nothing else
    std::optional<TokenKeys> tokens;  // none: everybody may open every model
    ServerLimits limits;
    unsigned threads = 0;         // 0: one a core, at most 4
    bool handle_signals = false;  // SIGINT, SIGTERM: the first drains, the second stops
    Log log;                      // empty: nothing is logged
};

/// Serves from start() until drain() or stop() has run its course. All calls from any thread.
class Server {
 public:
    /// Io where a folder or TLS file cannot be read or an address cannot be had.
    static Result<std::unique_ptr<Server>> start(ServerOptions options);
    ~Server();  // stops
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// Where it listens, with the port that the system chose.
    [[nodiscard]] protocol::HostPort tcp_address() const;
    [[nodiscard]] protocol::HostPort http_address() const;
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
