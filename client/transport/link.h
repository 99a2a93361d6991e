// A session with the transport that its URL asks for, behind one face. Inside the client only.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <variant>

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

/// What an owner is told, in order.
using Notice = std::variant<Opened, Received, Indexed, Satisfied, Broken, Resumed, Restarted, Failed>;

/// One model's download. All calls on the io_context's thread.
class Link {
 public:
    virtual ~Link() = default;
    virtual void restore(Stored stored) = 0;
    virtual void start() = 0;
    virtual void want(Wants wants) = 0;
    virtual void cancel() = 0;
    virtual void stop() = 0;
    /// The tag of what came by HTTP; else empty.
    [[nodiscard]] virtual std::string etag() const = 0;
};

struct LinkOptions {
    Wants wants;
    RetryPolicy retry;
    Limits limits;
    std::string token;
    std::uint32_t seed = 1;
    PacePtr pace{};  // may be null
};

/// `tell` may block: nothing is read meanwhile. `io` and `tls` (used where the URL says so) outlive the link.
std::unique_ptr<Link> make_link(boost::asio::io_context& io, boost::asio::ssl::context* tls, const Url& url,
                                LinkOptions options, std::function<void(Notice&&)> tell);

}  // namespace mvw::client
