#include "client/transport/tcp.h"

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

namespace mvw::client {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t kReadBytes = 64u << 10;

auto into(error_code& error) {
    return asio::redirect_error(asio::use_awaitable, error);
}

/// One connection, from the look-up of its name to its end. Coroutines of a connection that has been given up find
/// `alive` false and leave.
struct Connection {
    explicit Connection(asio::io_context& io) : resolver(io), socket(io) {}
    tcp::resolver resolver;
    tcp::socket socket;
    Bytes unsent;
    bool writing = false, alive = true;
};

}  // namespace

class TcpTransport::Impl : public std::enable_shared_from_this<TcpTransport::Impl> {
 public:
    Impl(asio::io_context& io, protocol::HostPort address, Session& session, Tell tell)
        : io_(io), timer_(io), address_(std::move(address)), session_(session), tell_(std::move(tell)) {}

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
        connection_ = std::make_shared<Connection>(io_);
        asio::co_spawn(
            io_, [self = shared_from_this(), c = connection_] { return self->run(c); }, asio::detached);
    }

    void disconnect() {
        if (!connection_) return;
        connection_->alive = false;
        connection_->resolver.cancel();
        error_code ignored;
        connection_->socket.close(ignored);
        connection_.reset();
    }

    asio::awaitable<void> run(ConnectionPtr c) {
        error_code error;
        const auto found =
            co_await c->resolver.async_resolve(address_.host, std::to_string(address_.port), into(error));
        if (c->alive && !error) co_await asio::async_connect(c->socket, found, into(error));
        if (!c->alive) co_return;
        if (error) co_return lost(c, "cannot connect to " + to_string(address_) + ": " + error.message());
        error_code ignored;
        c->socket.set_option(tcp::no_delay(true), ignored);
        perform(session_.on_connected(Clock::now()));
        Bytes buffer(kReadBytes);
        while (c->alive) {
            const std::size_t n = co_await c->socket.async_read_some(asio::buffer(buffer), into(error));
            if (!c->alive) co_return;
            if (error == asio::error::eof) co_return lost(c, "the server closed the connection");
            if (error) co_return lost(c, "the connection broke: " + error.message());
            perform(session_.on_bytes(ByteSpan(buffer.data(), n), Clock::now()));
        }
    }

    void lost(const ConnectionPtr& c, std::string why) {
        c->alive = false;
        error_code ignored;
        c->socket.close(ignored);
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
            co_await asio::async_write(c->socket, asio::buffer(bytes), into(error));
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
    asio::steady_timer timer_;
    const protocol::HostPort address_;
    Session& session_;
    const Tell tell_;
    ConnectionPtr connection_;
    bool stopped_ = false;
};

TcpTransport::TcpTransport(asio::io_context& io, protocol::HostPort address, Session& session, Tell tell)
    : impl_(std::make_shared<Impl>(io, std::move(address), session, std::move(tell))) {}
TcpTransport::~TcpTransport() = default;
void TcpTransport::perform(Actions actions) {
    impl_->perform(std::move(actions));
}
void TcpTransport::stop() {
    impl_->stop();
}

}  // namespace mvw::client
