#include "server/transport/http.h"

#include <fmt/format.h>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/rfc7230.hpp>

#include <algorithm>
#include <array>

#include "server/session.h"
#include "server/transport/peer.h"
#include "server/transport/waiting.h"
#include "server/transport/websocket.h"

namespace mvw::server {
namespace {

namespace http = boost::beast::http;
using Parser = http::request_parser<http::empty_body>;

constexpr std::size_t kReadBytes = 2048;
constexpr std::size_t kBodyBytes = 128u << 10;    // of a file, for one write
constexpr std::size_t kSendFileBytes = 1u << 20;  // the same without a copy: the socket's buffer bounds it anyway
constexpr std::chrono::seconds kLinger{1};        // for the peer to read our last words

std::string field_of(const Parser::value_type& request, http::field name) {
    const auto value = request[name];
    return {value.data(), value.size()};
}

std::string_view path_of(const Parser::value_type& request) {
    const std::string_view target(request.target().data(), request.target().size());
    return target.substr(0, target.find('?'));
}

bool is_upgrade(const Parser::value_type& request) {
    return http::token_list{request[http::field::connection]}.exists("upgrade") &&
           boost::beast::iequals(request[http::field::upgrade], "websocket");
}

/// One connection: a coroutine for requests and one for the timer; both end when it turns into a WebSocket peer.
class HttpConnection final : public Connection, public std::enable_shared_from_this<HttpConnection> {
 public:
    HttpConnection(std::unique_ptr<Carrier> carrier, const PeerContext& context, const Site& site, std::string name,
                   std::function<void()> on_end)
        : strand_(carrier->strand()),
          carrier_(std::move(carrier)),
          timer_(strand_),
          context_(context),
          site_(site),
          name_(std::move(name)),
          on_end_(std::move(on_end)),
          tokens_(context.limits.message_burst) {
        ++context_.metrics.opened[kIndex];
    }
    ~HttpConnection() override { ++context_.metrics.closed[kIndex]; }

    Strand strand() override { return strand_; }
    void start() override {
        const auto self = shared_from_this();
        asio::co_spawn(
            strand_, [self] { return self->serve(); }, asio::detached);
        asio::co_spawn(
            strand_, [self] { return self->timer_loop(); }, asio::detached);
    }
    void drain() override {
        if (peer_) return peer_->drain();
        draining_ = true;
        if (state_ == State::Waiting) end("draining");
    }
    void end(const std::string& reason) override {
        if (peer_) return peer_->end(reason);
        if (std::exchange(ended_, true)) return;
        carrier_->close();
        timer_.cancel();
        context_.log(LogLevel::Debug, fmt::format("event=closed transport=http peer={} requests={} bytes={} reason={}",
                                                  name_, requests_, bytes_, log_value(reason)));
        on_end_();
    }

 private:
    using Fetch = std::function<void(Fetched)>;
    enum class State {
        Handshake,  // TLS
        Reading,    // a request's head
        Waiting,    // for another request
        Sending,
        Lingering,
    };
    static constexpr std::size_t kIndex = static_cast<std::size_t>(Way::Http);

    asio::awaitable<void> serve() {
        set_due(context_.limits.header_time);
        error_code error;
        co_await carrier_->handshake(error);
        if (error) end("no TLS: " + error.message());
        for (bool first = true; !ended_; first = false) {
            Parser parser;
            parser.header_limit(context_.limits.max_http_head_bytes);
            parser.body_limit(UINT64_MAX);  // bodies are refused by answer()
            HttpReply reply;
            bool keep = co_await read_head(parser, first, reply);
            if (ended_) co_return;
            if (keep) {
                if (is_stream_request(parser.get())) {
                    become_peer(parser.get());
                    co_return;
                }
                keep = answer(parser, reply);
                while (!reply.waits_for.empty()) {
                    const auto known = [this, &reply](std::function<void(bool)> then) {
                        context_.when_known(reply.waits_for, [then = std::move(then)] { then(true); });
                    };
                    const std::function<void(std::function<void(bool)>)> begin = known;
                    enter(State::Sending, context_.limits.stall_time);
                    co_await wait_for<bool>(strand_, begin);
                    if (ended_) co_return;
                    look_up(parser.get(), reply);
                }
            }
            const bool sent = co_await send(reply, keep);
            if (!sent) co_return;
            if (!keep || draining_) {
                co_await finish();
                co_return;
            }
        }
    }

    // A whole head. False where there is none to be had: the connection has ended, or `refusal` says why.
    asio::awaitable<bool> read_head(Parser& parser, bool first, HttpReply& refusal) {
        const bool begun = first || !unread_.empty();
        enter(begun ? State::Reading : State::Waiting,
              begun ? context_.limits.header_time : context_.limits.http_idle_time);
        std::array<char, kReadBytes> buffer;
        while (true) {
            error_code error;
            if (!unread_.empty()) {
                const std::size_t n = parser.put(asio::buffer(unread_), error);
                unread_.erase(unread_.begin(), unread_.begin() + static_cast<std::ptrdiff_t>(n));
                if (parser.is_header_done()) co_return true;
                if (error && error != http::error::need_more) {
                    ++context_.metrics.malformed;
                    refusal = error == http::error::header_limit ? plain_reply(431, "the request's head is too large")
                                                                 : plain_reply(400, "the request cannot be read");
                    co_return false;
                }
            }
            const std::size_t n = co_await carrier_->read(asio::buffer(buffer), error);
            if (ended_) co_return false;
            if (timed_out_) {
                ++context_.metrics.timeouts;
                refusal = plain_reply(408, "the request's head took too long");
                co_return false;
            }
            if (error) {
                end(error == asio::error::eof ? "peer left" : error.message());
                co_return false;
            }
            if (state_ == State::Waiting) enter(State::Reading, context_.limits.header_time);
            unread_.insert(unread_.end(), buffer.begin(), buffer.begin() + n);
        }
    }

    [[nodiscard]] bool is_stream_request(const Parser::value_type& request) const {
        return path_of(request) == kStreamPath && is_upgrade(request) && unread_.empty();
    }

    // Fills in the reply; false where the connection is to end with it.
    bool answer(const Parser& parser, HttpReply& reply) {
        const auto& request = parser.get();
        ++requests_;
        if (parser.chunked() || parser.content_length().value_or(0) > 0) {
            reply = plain_reply(413, "requests have no body here");
            return false;
        }
        if (!take_token()) {
            reply = plain_reply(429, "too many requests a second");
            reply.fields.emplace_back("Retry-After", "1");
            return false;
        }
        if (path_of(request) == kStreamPath) {
            reply = plain_reply(426, "only WebSocket is spoken here");
            reply.fields.emplace_back("Upgrade", "websocket");
            return false;
        }
        look_up(request, reply);
        return parser.keep_alive() && !draining_;
    }

    void look_up(const Parser::value_type& request, HttpReply& reply) {
        reply = site_.answer({std::string(request.method_string()),
                              {request.target().data(), request.target().size()},
                              field_of(request, http::field::range),
                              field_of(request, http::field::if_range),
                              field_of(request, http::field::if_none_match),
                              field_of(request, http::field::authorization),
                              field_of(request, http::field::accept_encoding)});
        if (reply.status == 401 || reply.status == 403) ++context_.metrics.forbidden;
    }

    asio::awaitable<bool> send(const HttpReply& reply, bool keep_alive) {
        enter(State::Sending, context_.limits.stall_time);
        if (reply.status < context_.metrics.http_answers.size()) ++context_.metrics.http_answers[reply.status];
        std::string head = reply.head(keep_alive);
        if (!reply.without_body) head += reply.text;
        const bool more = !reply.without_body && reply.source && reply.length > 0;
        if (!co_await write_all(asio::buffer(head), more)) co_return false;
        if (!more) co_return true;
        const bool sent = co_await send_source(*reply.source, reply.offset, reply.length);
        co_return sent;
    }

    // A file that shrinks or is overwritten breaks the connection: the peer sees that the body is cut.
    asio::awaitable<bool> send_source(const ByteSource& source, std::uint64_t offset, std::uint64_t length) {
        const auto* model = dynamic_cast<const ModelSource*>(&source);
        const bool as_file = carrier_->can_send_file() && source.descriptor() >= 0;
        Bytes buffer(as_file ? 0 : std::min<std::uint64_t>(length, kBodyBytes));
        while (length > 0) {
            const auto n =
                static_cast<std::size_t>(std::min<std::uint64_t>(length, as_file ? kSendFileBytes : kBodyBytes));
            if (model != nullptr && !model->intact()) {
                end("the file was overwritten");
                co_return false;
            }
            if (!source.ready(offset, n)) {
                const Fetch fetch = [&](const Fetched& done) { source.fetch(offset, n, done); };
                const Result<void> fetched = co_await wait_for<Result<void>>(strand_, fetch);
                if (ended_) co_return false;
                if (!fetched) {
                    end("the file cannot be had: " + fetched.error().message);
                    co_return false;
                }
            }
            std::size_t sent = n;
            if (as_file) {
                error_code error;
                sent = co_await carrier_->send_file(source.descriptor(), offset, n, error);
                if (!took(sent, sent == 0 && !error ? asio::error::eof : error)) co_return false;
            } else {
                if (Result<void> r = source.read(offset, std::span(buffer).first(n)); !r) {
                    end("the file cannot be read: " + r.error().message);
                    co_return false;
                }
                if (!co_await write_all(asio::buffer(buffer.data(), n), n < length)) co_return false;
            }
            offset += sent;
            length -= sent;
        }
        co_return true;
    }

    asio::awaitable<bool> write_all(asio::const_buffer bytes, bool more) {
        while (bytes.size() > 0) {
            error_code error;
            const std::size_t n =
                more ? co_await carrier_->write_before_more(bytes, error) : co_await carrier_->write(bytes, error);
            if (!took(n, error)) co_return false;
            bytes += n;
        }
        co_return !ended_;
    }

    bool took(std::size_t n, const error_code& error) {
        if (ended_) return false;
        if (error) {
            end(error.message());
            return false;
        }
        bytes_ += n;
        context_.metrics.bytes_sent[kIndex] += n;
        set_due(context_.limits.stall_time);
        return true;
    }

    // Our last words have been sent: gives the peer a moment to read them, since closing at once over bytes that were
    // not read would take them back. What it still says is thrown away.
    asio::awaitable<void> finish() {
        enter(State::Lingering, kLinger);
        co_await carrier_->finish();
        std::array<char, kReadBytes> buffer;
        error_code error;
        while (!ended_ && !error) co_await carrier_->read(asio::buffer(buffer), error);
        end("closed");
    }

    void become_peer(const Parser::value_type& request) {
        UpgradeRequest r{std::string(request.target().data(), request.target().size()),
                         field_of(request, http::field::host), field_of(request, http::field::sec_websocket_key),
                         field_of(request, http::field::sec_websocket_version),
                         field_of(request, http::field::sec_websocket_protocol)};
        peer_ = make_peer(upgrade(std::move(carrier_), std::move(r), context_.limits), Way::WebSocket, context_, name_,
                          on_end_);
        timer_.cancel();
        peer_->start();
        if (draining_) peer_->drain();
    }

    void enter(State state, std::chrono::milliseconds time) {
        state_ = state;
        set_due(time);
    }
    void set_due(std::chrono::milliseconds time) {
        due_ = Clock::now() + time;
        if (due_ < timer_.expiry()) timer_.cancel();  // one that fires early looks again
    }

    asio::awaitable<void> timer_loop() {
        while (!ended_ && !peer_) {
            // Never further than the shortest time that a state is given: moving it with every request would cost more.
            timer_.expires_at(std::min(due_, Clock::now() + tick_));
            error_code error;
            co_await timer_.async_wait(into(error));
            if (ended_ || peer_) co_return;
            if (Clock::now() < due_) continue;  // moved
            if (state_ == State::Reading && !timed_out_) {
                timed_out_ = true;  // read_head() says so to the peer
                due_ = Clock::now() + kLinger;
                carrier_->cancel();
            } else {
                if (state_ != State::Lingering && state_ != State::Waiting) ++context_.metrics.timeouts;
                end(state_ == State::Waiting ? "idle" : state_ == State::Lingering ? "closed" : "timeout");
            }
        }
    }

    // Token bucket, as of the native protocol's messages.
    bool take_token() {
        const Clock::time_point now = Clock::now();
        const std::chrono::duration<double> elapsed = now - tokens_at_;
        tokens_at_ = now;
        tokens_ =
            std::min(context_.limits.message_burst, tokens_ + elapsed.count() * context_.limits.messages_per_second);
        if (tokens_ < 1) return false;
        tokens_ -= 1;
        return true;
    }

    const Strand strand_;
    std::unique_ptr<Carrier> carrier_;  // null once it is the peer's
    Timer timer_;
    const PeerContext& context_;
    const Site& site_;
    const std::string name_;
    const std::function<void()> on_end_;
    std::shared_ptr<Connection> peer_;  // once it has turned into a WebSocket
    std::vector<char> unread_;
    State state_ = State::Handshake;
    Clock::time_point due_ = Clock::time_point::max();
    const std::chrono::milliseconds tick_ =
        std::min({context_.limits.header_time, context_.limits.stall_time, context_.limits.http_idle_time});
    bool draining_ = false, timed_out_ = false, ended_ = false;
    double tokens_;
    Clock::time_point tokens_at_ = Clock::now();
    std::uint64_t requests_ = 0, bytes_ = 0;
};

}  // namespace

std::shared_ptr<Connection> make_http(std::unique_ptr<Carrier> carrier, const PeerContext& context, const Site& site,
                                      std::string name, std::function<void()> on_end) {
    return std::make_shared<HttpConnection>(std::move(carrier), context, site, std::move(name), std::move(on_end));
}

}  // namespace mvw::server
