#include "client/transport/http.h"

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>

#include <charconv>

#include "client/transport/paced_wire.h"

namespace mvw::client {
namespace {

namespace http = boost::beast::http;
using Parser = http::response_parser<http::buffer_body>;

constexpr std::size_t kReadBytes = 64u << 10;
constexpr std::uint32_t kMaxHeadBytes = 32u << 10;

/// One connection. Coroutines of one that has been given up find `alive` false and leave.
struct Connection {
    std::unique_ptr<Wire> wire;
    bool connected = false, alive = true;
    Bytes unread;  // came behind the last answer
};

// "bytes 5-9/698": 5. No number: the largest, which is asked for by nobody.
std::uint64_t first_of(std::string_view content_range) {
    constexpr std::string_view kUnit = "bytes ";
    std::uint64_t first = UINT64_MAX;
    if (content_range.starts_with(kUnit)) {
        content_range.remove_prefix(kUnit.size());
        std::from_chars(content_range.data(), content_range.data() + content_range.size(), first);
    }
    return first;
}

HttpAnswer answer_of(const Parser::value_type& response) {
    const auto text = [&](http::field f) {
        const auto value = response[f];
        return std::string_view(value.data(), value.size());
    };
    HttpAnswer answer;
    answer.status = response.result_int();
    const std::string_view etag = text(http::field::etag);
    if (!etag.starts_with("W/")) answer.etag = etag;
    if (answer.status == 206) answer.first = first_of(text(http::field::content_range));
    return answer;
}

}  // namespace

class HttpTransport::Impl : public std::enable_shared_from_this<HttpTransport::Impl> {
 public:
    Impl(asio::io_context& io, Url url, std::string token, asio::ssl::context* tls, HttpSession& session, Tell tell,
         PacePtr pace)
        : io_(io),
          tls_(tls),
          timer_(io),
          url_(std::move(url)),
          token_(std::move(token)),
          session_(session),
          tell_(std::move(tell)),
          pace_(std::move(pace)) {}

    void perform(HttpActions actions) {
        for (HttpAction& action : actions) {
            if (stopped_) return;
            if (const auto* get = std::get_if<Get>(&action))
                begin(*get);
            else if (std::holds_alternative<Abandon>(action))
                disconnect();
            else if (const auto* timer = std::get_if<SetTimer>(&action))
                set_timer(timer->at);
            else
                tell_(std::move(action));
        }
    }

    void stop() {
        stopped_ = true;
        timer_.cancel();
        disconnect();
    }

 private:
    using ConnectionPtr = std::shared_ptr<Connection>;

    [[nodiscard]] ConnectionPtr fresh_connection() {
        return std::make_shared<Connection>(
            Connection{at_pace(io_, make_wire(io_, url_, tls_), pace_), false, true, {}});
    }

    void begin(const Get& get) {
        const bool kept = connection_ != nullptr;
        if (!kept) connection_ = fresh_connection();
        auto request = std::make_shared<const std::string>(head_of(get));
        asio::co_spawn(
            io_, [self = shared_from_this(), c = connection_, request, kept] { return self->run(c, *request, kept); },
            asio::detached);
    }

    [[nodiscard]] std::string head_of(const Get& get) const {
        const bool default_port = url_.address.port == (url_.tls ? 443 : 80);
        std::string host = to_string(url_.address);
        if (default_port) host.resize(host.rfind(':'));
        std::string out = "GET " + url_.target + " HTTP/1.1\r\nHost: " + host + "\r\nUser-Agent: mvw\r\n";
        if (get.first > 0 || get.last) {
            out += "Range: bytes=" + std::to_string(get.first) + "-" + (get.last ? std::to_string(*get.last) : "") +
                   "\r\n";
            if (!get.if_range.empty()) out += "If-Range: " + get.if_range + "\r\n";
        }
        if (!token_.empty()) out += "Authorization: Bearer " + token_ + "\r\n";
        return out + "\r\n";
    }

    void disconnect() {
        if (!connection_) return;
        connection_->alive = false;
        connection_->wire->close();
        connection_.reset();
    }

    // The request and its answer.
    asio::awaitable<void> run(ConnectionPtr c, const std::string& request, bool kept) {
        error_code error;
        if (!c->connected) co_await c->wire->connect(error);
        if (!c->alive) co_return;
        if (error) co_return lost(c, "cannot connect to " + to_string(url_.address) + ": " + error.message());
        c->connected = true;
        co_await c->wire->write(asio::buffer(request), error);
        if (!c->alive) co_return;
        Parser parser;
        parser.eager(true);
        parser.header_limit(kMaxHeadBytes);
        parser.body_limit(UINT64_MAX);
        Bytes buffer(kReadBytes), body(kReadBytes);
        bool answered = false;
        while (c->alive && !error) {
            if (!take(*c, parser, body, answered, error)) co_return;
            if (error || parser.is_done()) break;
            const std::size_t n = co_await c->wire->read(asio::buffer(buffer), error);
            if (!c->alive) co_return;
            c->unread.insert(c->unread.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(n));
            if (error == asio::error::eof && parser.got_some()) parser.put_eof(error);
        }
        if (!c->alive) co_return;
        if (error && kept && !answered && c->unread.empty()) co_return again(c, request);
        if (error)
            co_return lost(c, error == asio::error::eof ? "the server closed the connection"
                                                        : "the connection broke: " + error.message());
        if (!parser.keep_alive() || !c->unread.empty()) disconnect();
        perform(session_.on_body_end(Clock::now()));
    }

    // Hands on what has come. False where the session has given the connection up meanwhile.
    bool take(Connection& c, Parser& parser, Bytes& body, bool& answered, error_code& error) {
        while (!c.unread.empty() && !parser.is_done()) {
            if (parser.is_header_done()) {
                parser.get().body().data = body.data();
                parser.get().body().size = body.size();
            }
            const std::size_t n = parser.put(asio::buffer(c.unread), error);
            c.unread.erase(c.unread.begin(), c.unread.begin() + static_cast<std::ptrdiff_t>(n));
            const bool needs_more = error == http::error::need_more;
            if (needs_more || error == http::error::need_buffer) error = {};
            if (parser.is_header_done() && !std::exchange(answered, true)) {
                perform(session_.on_answer(answer_of(parser.get()), Clock::now()));
                if (!c.alive) return false;
            }
            if (const std::size_t got = body.size() - parser.get().body().size;
                answered && parser.get().body().data && got > 0) {
                perform(session_.on_body(ByteSpan(body).first(got), Clock::now()));
                parser.get().body().data = nullptr;
                if (!c.alive) return false;
            }
            if (error || needs_more) break;
        }
        return true;
    }

    // A connection that was kept has been closed by the server meanwhile, which is its right: a new one.
    void again(const ConnectionPtr& c, const std::string& request) {
        c->alive = false;
        c->wire->close();
        connection_ = fresh_connection();
        auto text = std::make_shared<const std::string>(request);
        asio::co_spawn(
            io_, [self = shared_from_this(), fresh = connection_, text] { return self->run(fresh, *text, false); },
            asio::detached);
    }

    void lost(const ConnectionPtr& c, std::string why) {
        c->alive = false;
        c->wire->close();
        if (connection_ == c) connection_.reset();
        perform(session_.on_disconnected({Errc::Io, 0, std::move(why)}, Clock::now()));
    }

    void set_timer(Clock::time_point at) {
        timer_.expires_at(at);
        timer_.async_wait([self = shared_from_this()](const error_code& error) {
            if (!error && !self->stopped_) self->perform(self->session_.on_timer(Clock::now()));
        });
    }

    asio::io_context& io_;
    asio::ssl::context* const tls_;
    asio::steady_timer timer_;
    const Url url_;
    const std::string token_;
    HttpSession& session_;
    const Tell tell_;
    const PacePtr pace_;
    ConnectionPtr connection_;
    bool stopped_ = false;
};

HttpTransport::HttpTransport(asio::io_context& io, Url url, std::string token, asio::ssl::context* tls,
                             HttpSession& session, Tell tell, PacePtr pace)
    : impl_(std::make_shared<Impl>(io, std::move(url), std::move(token), tls, session, std::move(tell),
                                   std::move(pace))) {}
HttpTransport::~HttpTransport() = default;
void HttpTransport::perform(HttpActions actions) {
    impl_->perform(std::move(actions));
}
void HttpTransport::stop() {
    impl_->stop();
}

}  // namespace mvw::client
