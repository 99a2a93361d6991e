// Carries a client session over a wire (TCP, TLS or WebSocket): connects, moves bytes, keeps the session's timer,
// nothing else.
#pragma once
#include <functional>
#include <memory>

#include "client/pace.h"
#include "client/session.h"
#include "client/url.h"

namespace boost::asio {
class io_context;
namespace ssl {
class context;
}
}  // namespace boost::asio

namespace mvw::client {

/// Performs a session's actions on one thread, that of the io_context.
class StreamTransport {
 public:
    /// `tell` gets every action that is not the transport's own business. It may block: nothing is read meanwhile.
    using Tell = std::function<void(Action&&)>;

    /// `io`, `session` and `tls` (used where the URL says so) outlive the transport.
    /// `pace` may be null.
    StreamTransport(boost::asio::io_context& io, Url url, boost::asio::ssl::context* tls, Session& session, Tell tell,
                    PacePtr pace = nullptr);
    ~StreamTransport();
    StreamTransport(const StreamTransport&) = delete;
    StreamTransport& operator=(const StreamTransport&) = delete;

    /// Performs what a call of the session gave.
    void perform(Actions actions);
    /// Closes the connection and the timer: the io_context runs out of work.
    void stop();

 private:
    class Impl;
    std::shared_ptr<Impl> impl_;
};

}  // namespace mvw::client
