#include "client/transport/link.h"

#include <type_traits>
#include <utility>

#include "client/http_session.h"
#include "client/transport/http.h"
#include "client/transport/stream.h"

namespace mvw::client {

namespace asio = boost::asio;

namespace {

// Hands on what is a notice; the rest was the transport's business.
template <typename AnyAction>
void pass_on(AnyAction&& action, const std::function<void(Notice&&)>& tell) {
    std::visit(
        [&](auto& a) {
            if constexpr (std::is_constructible_v<Notice, decltype(std::move(a))>) tell(Notice(std::move(a)));
        },
        action);
}

class NativeLink final : public Link {
 public:
    NativeLink(asio::io_context& io, asio::ssl::context* tls, const Url& url, LinkOptions options,
               std::function<void(Notice&&)> tell)
        : session_(url.model, std::move(options.token), std::move(options.wants), options.retry, options.limits,
                   options.seed),
          transport_(
              io, url, tls, session_, [t = std::move(tell)](Action&& action) { pass_on(action, t); }, options.pace) {}
    void restore(Stored stored) override { session_.restore(std::move(stored)); }
    void start() override { transport_.perform(session_.start(Clock::now())); }
    void want(Wants wants) override { transport_.perform(session_.want(std::move(wants), Clock::now())); }
    void cancel() override { transport_.perform(session_.cancel(Clock::now())); }
    void stop() override { transport_.stop(); }
    std::string etag() const override { return {}; }

 private:
    Session session_;
    StreamTransport transport_;
};

class HttpLink final : public Link {
 public:
    HttpLink(asio::io_context& io, asio::ssl::context* tls, const Url& url, LinkOptions options,
             std::function<void(Notice&&)> tell)
        : session_(std::move(options.wants), options.retry, options.limits, options.seed),
          transport_(
              io, url, std::move(options.token), tls, session_,
              [t = std::move(tell)](HttpAction&& action) { pass_on(action, t); }, options.pace) {}
    void restore(Stored stored) override { session_.restore(std::move(stored)); }
    void start() override { transport_.perform(session_.start(Clock::now())); }
    void want(Wants wants) override { transport_.perform(session_.want(std::move(wants), Clock::now())); }
    void cancel() override { transport_.perform(session_.cancel(Clock::now())); }
    void stop() override { transport_.stop(); }
    std::string etag() const override { return session_.etag(); }

 private:
    HttpSession session_;
    HttpTransport transport_;
};

}  // namespace

std::unique_ptr<Link> make_link(asio::io_context& io, asio::ssl::context* tls, const Url& url, LinkOptions options,
                                std::function<void(Notice&&)> tell) {
    if (url.scheme == Scheme::Http)
        return std::make_unique<HttpLink>(io, tls, url, std::move(options), std::move(tell));
    return std::make_unique<NativeLink>(io, tls, url, std::move(options), std::move(tell));
}

}  // namespace mvw::client
