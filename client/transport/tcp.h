// Carries a client session over TCP: connects, moves bytes, keeps the session's timer, nothing else.
#pragma once
#include <functional>
#include <memory>

#include "client/session.h"
#include "server/protocol/address.h"

namespace boost::asio {
class io_context;
}

namespace mvw::client {

/// Performs a session's actions on one thread, that of the io_context.
class TcpTransport {
 public:
    /// `tell` gets every action that is not the transport's own business. It may block: nothing is read meanwhile.
    using Tell = std::function<void(Action&&)>;

    /// `io` and `session` outlive the transport.
    TcpTransport(boost::asio::io_context& io, protocol::HostPort address, Session& session, Tell tell);
    ~TcpTransport();
    TcpTransport(const TcpTransport&) = delete;
    TcpTransport& operator=(const TcpTransport&) = delete;

    /// Performs what a call of the session gave.
    void perform(Actions actions);
    /// Closes the connection and the timer: the io_context runs out of work.
    void stop();

 private:
    class Impl;
    std::shared_ptr<Impl> impl_;
};

}  // namespace mvw::client
