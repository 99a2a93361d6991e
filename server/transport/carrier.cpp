#include "server/transport/carrier.h"

#include <sys/sendfile.h>
#include <sys/socket.h>

#include <boost/asio/post.hpp>

#include <cerrno>

namespace mvw::server {
namespace {

constexpr std::size_t kMostInARow = 256u << 10;  // bytes sent without a turn for others

}  // namespace

asio::awaitable<std::size_t> Carrier::send_file(int, std::uint64_t, std::size_t, error_code& error) {
    error = asio::error::operation_not_supported;
    co_return 0;
}

asio::awaitable<void> TcpCarrier::handshake(error_code& error) {
    error = {};
    co_return;
}

asio::awaitable<std::size_t> TcpCarrier::read(asio::mutable_buffer out, error_code& error) {
    co_return co_await socket_.async_read_some(out, into(error));
}

TcpCarrier::TcpCarrier(Socket socket) : socket_(std::move(socket)) {
    error_code ignored;  // send() then says so
    socket_.native_non_blocking(true, ignored);
}

// Tries at once: most of the time the socket has room, and no one has to be woken. `call` gives what it moved, or -1.
template <typename Call>
asio::awaitable<std::size_t> TcpCarrier::move_out(Call call, error_code& error) {
    while (!error) {
        const ssize_t n = call();
        const int why = errno;
        if (n >= 0) {
            if (is_long_turn(static_cast<std::size_t>(n))) co_await asio::post(socket_.get_executor(), into(error));
            co_return static_cast<std::size_t>(n);
        }
        if (why == EAGAIN || why == EWOULDBLOCK)
            co_await socket_.async_wait(tcp::socket::wait_write, into(error));
        else if (why != EINTR)
            error = error_code(why, boost::system::system_category());
    }
    co_return 0;
}

asio::awaitable<std::size_t> TcpCarrier::write(asio::const_buffer bytes, error_code& error) {
    return send(bytes, 0, error);
}

asio::awaitable<std::size_t> TcpCarrier::write_before_more(asio::const_buffer bytes, error_code& error) {
    return send(bytes, MSG_MORE, error);
}

asio::awaitable<std::size_t> TcpCarrier::send(asio::const_buffer bytes, int flags, error_code& error) {
    return move_out([socket = socket_.native_handle(), bytes,
                     flags] { return ::send(socket, bytes.data(), bytes.size(), flags | MSG_NOSIGNAL); },
                    error);
}

asio::awaitable<std::size_t> TcpCarrier::send_file(int file, std::uint64_t offset, std::size_t count,
                                                   error_code& error) {
    return move_out(
        [socket = socket_.native_handle(), file, offset, count] {
            auto at = static_cast<off_t>(offset);
            return ::sendfile(socket, file, &at, count);
        },
        error);
}

// A fast reader would never make us wait: the other connections of this thread have their turn nevertheless.
bool TcpCarrier::is_long_turn(std::size_t sent) {
    sent_in_a_row_ += sent;
    if (sent_in_a_row_ < kMostInARow) return false;
    sent_in_a_row_ = 0;
    return true;
}

asio::awaitable<void> TcpCarrier::finish() {
    error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
    co_return;
}

void TcpCarrier::cancel() {
    error_code ignored;
    socket_.cancel(ignored);
}

void TcpCarrier::close() {
    error_code ignored;
    socket_.close(ignored);
}

asio::awaitable<void> TlsCarrier::handshake(error_code& error) {
    co_await stream_.async_handshake(asio::ssl::stream_base::server, into(error));
}

asio::awaitable<std::size_t> TlsCarrier::read(asio::mutable_buffer out, error_code& error) {
    const std::size_t n = co_await stream_.async_read_some(out, into(error));
    // An end without TLS's own farewell: what came before it was whole, so it is an end like any other here.
    if (error == asio::ssl::error::stream_truncated) error = asio::error::eof;
    co_return n;
}

asio::awaitable<std::size_t> TlsCarrier::write(asio::const_buffer bytes, error_code& error) {
    co_return co_await stream_.async_write_some(bytes, into(error));
}

// Waits for the peer's farewell as well, so the caller keeps a timer.
asio::awaitable<void> TlsCarrier::finish() {
    error_code ignored;
    co_await stream_.async_shutdown(into(ignored));
}

void TlsCarrier::cancel() {
    error_code ignored;
    stream_.next_layer().cancel(ignored);
}

void TlsCarrier::close() {
    error_code ignored;
    stream_.next_layer().close(ignored);
}

std::unique_ptr<Carrier> make_carrier(Socket socket, asio::ssl::context* tls) {
    if (tls != nullptr) return std::make_unique<TlsCarrier>(std::move(socket), *tls);
    return std::make_unique<TcpCarrier>(std::move(socket));
}

}  // namespace mvw::server
