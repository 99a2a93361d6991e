// Carries an HttpSession: one request at a time over a connection that is kept, nothing else.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "client/http_session.h"
#include "client/pace.h"
#include "client/url.h"

namespace boost::asio {
class io_context;
namespace ssl {
class context;
}
}  // namespace boost::asio

namespace mvw::client {

/// Performs a session's actions on one thread, that of the io_context.
class HttpTransport {
 public:
    /// `tell` gets every action that is not the transport's own business. It may block: nothing is read meanwhile.
    using Tell = std::function<void(HttpAction&&)>;

    /// `io`, `session` and `tls` (used where the URL says so) outlive the transport. `token` goes along as a Bearer
    /// token, unless it is empty. `pace` may be null.
    HttpTransport(boost::asio::io_context& io, Url url, std::string token, boost::asio::ssl::context* tls,
                  HttpSession& session, Tell tell, PacePtr pace = nullptr);
    ~HttpTransport();
    HttpTransport(const HttpTransport&) = delete;
    HttpTransport& operator=(const HttpTransport&) = delete;

    /// Performs what a call of the session gave.
    void perform(HttpActions actions);
    /// Closes the connection and the timer: the io_context runs out of work.
    void stop();

 private:
    class Impl;
    std::shared_ptr<Impl> impl_;
};

}  // namespace mvw::client
