#include "client/transport/stream.h"

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/steady_timer.hpp>

#include "client/transport/paced_wire.h"

namespace mvw::client {
namespace {

constexpr std::size_t kReadBytes = 64u << 10;

/// One connection, from the look-up of its name to its end. Coroutines of a connection that has been given up find
/// `alive` false and leave.
struct Connection {
    std::unique_ptr<Wire> wire;
    Bytes unsent;
    bool writing = false, alive = true;
};

}  // namespace

class StreamTransport::Impl : public std::enable_shared_from_this<StreamTransport::Impl> {
 public:
    Impl(asio::io_context& io, Url url, asio::ssl::context* tls, Session& session, Tell tell, PacePtr pace)
        : io_(io),
          tls_(tls),
          timer_(io),
          url_(std::move(url)),
          session_(session),
          tell_(std::move(tell)),
          pace_(std::move(pace)) {}

    void perform(Actions actions) {
        for (Action& action : actions) {
            if (stopped_) return;
            if (std::holds_alternative<Connect>(action))
                connect();
            else if (auto* bytes = std::get_if<SendBytes>(&action))
                send(bytes->bytes);
            else if (const auto* timer = std::get_if<SetTimer>(&action))
                set_timer(timer->at);
            else if (std::holds_alternative<Disconnect>(action))
                disconnect();
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

    void connect() {
        disconnect();
        connection_ =
            std::make_shared<Connection>(Connection{at_pace(io_, make_wire(io_, url_, tls_), pace_), {}, false, true});
        asio::co_spawn(
            io_, [self = shared_from_this(), c = connection_] { return self->run(c); }, asio::detached);
    }

    void disconnect() {
        if (!connection_) return;
        connection_->alive = false;
        connection_->wire->close();
        connection_.reset();
    }

    asio::awaitable<void> run(ConnectionPtr c) {
        error_code error;
        co_await c->wire->connect(error);
        if (!c->alive) co_return;
        if (error) co_return lost(c, "cannot connect to " + to_string(url_.address) + ": " + error.message());
        perform(session_.on_connected(Clock::now()));
        Bytes buffer(kReadBytes);
        while (c->alive) {
            const std::size_t n = co_await c->wire->read(asio::buffer(buffer), error);
            if (!c->alive) co_return;
            if (error == asio::error::eof) co_return lost(c, "the server closed the connection");
            if (error) co_return lost(c, "the connection broke: " + error.message());
            perform(session_.on_bytes(ByteSpan(buffer.data(), n), Clock::now()));
        }
    }

    void lost(const ConnectionPtr& c, std::string why) {
        c->alive = false;
        c->wire->close();
        if (connection_ == c) connection_.reset();
        perform(session_.on_disconnected({Errc::Io, 0, std::move(why)}, Clock::now()));
    }

    void send(const Bytes& bytes) {
        if (!connection_) return;
        connection_->unsent.insert(connection_->unsent.end(), bytes.begin(), bytes.end());
        if (std::exchange(connection_->writing, true)) return;
        asio::co_spawn(
            io_, [self = shared_from_this(), c = connection_] { return self->write(c); }, asio::detached);
    }

    // A failed write needs no word: the reader meets the same end.
    asio::awaitable<void> write(ConnectionPtr c) {
        error_code error;
        while (c->alive && !error && !c->unsent.empty()) {
            const Bytes bytes = std::exchange(c->unsent, {});
            co_await c->wire->write(asio::buffer(bytes), error);
        }
        c->writing = false;
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
    Session& session_;
    const Tell tell_;
    const PacePtr pace_;
    ConnectionPtr connection_;
    bool stopped_ = false;
};

StreamTransport::StreamTransport(asio::io_context& io, Url url, asio::ssl::context* tls, Session& session, Tell tell,
                                 PacePtr pace)
    : impl_(std::make_shared<Impl>(io, std::move(url), tls, session, std::move(tell), std::move(pace))) {}
StreamTransport::~StreamTransport() = default;
void StreamTransport::perform(Actions actions) {
    impl_->perform(std::move(actions));
}
void StreamTransport::stop() {
    impl_->stop();
}

}  // namespace mvw::client
