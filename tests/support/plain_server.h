// An HTTP server that knows nothing: every request gets one whole body, Range or not.
#pragma once
#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

#include <atomic>
#include <string>
#include <thread>

#include "codec/bytes.h"
#include "server/protocol/address.h"

namespace mvw::test {

class PlainServer {
 public:
    explicit PlainServer(const Bytes& body);
    ~PlainServer();
    [[nodiscard]] protocol::HostPort address() const { return {"127.0.0.1", acceptor_.local_endpoint().port()}; }
    [[nodiscard]] unsigned requests() const { return requests_; }

 private:
    void run();

    const std::string answer_;
    boost::asio::io_context io_;
    boost::asio::ip::tcp::acceptor acceptor_;
    std::atomic<bool> stopping_ = false;
    std::atomic<unsigned> requests_ = 0;
    std::thread thread_;  // last: it uses all of the above
};

}  // namespace mvw::test
