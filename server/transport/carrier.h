// One connection's bytes, whatever wraps them: plain TCP, TLS, or WebSocket on either. What speaks over it (peer.h,
// http.h) does not know which. Inside the transport folder only: the rest of the server sees no socket.
#pragma once
#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/use_awaitable.hpp>

#include <chrono>
#include <memory>

namespace mvw::server {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Strand = asio::strand<asio::io_context::executor_type>;
using Socket = asio::basic_stream_socket<tcp, Strand>;
using TlsStream = asio::ssl::stream<Socket>;
using Timer =
    asio::basic_waitable_timer<std::chrono::steady_clock, asio::wait_traits<std::chrono::steady_clock>, Strand>;

/// For co_await: errors into a variable instead of an exception.
inline auto into(error_code& error) {
    return asio::redirect_error(asio::use_awaitable, error);
}

/// Bytes in both directions; all calls on the connection's strand. One read and one write may be under way together.
/// A peer that has said that no more will come gives asio::error::eof.
class Carrier {
 public:
    virtual ~Carrier() = default;
    [[nodiscard]] virtual Strand strand() = 0;
    /// What has to be agreed on before the first byte (TLS).
    virtual asio::awaitable<void> handshake(error_code& error) = 0;
    /// Some bytes, at least one.
    virtual asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) = 0;
    /// Takes some of the bytes, at least one.
    virtual asio::awaitable<std::size_t> write(asio::const_buffer bytes, error_code& error) = 0;
    /// The same where other bytes follow at once: a packet may wait for them.
    virtual asio::awaitable<std::size_t> write_before_more(asio::const_buffer bytes, error_code& error) {
        return write(bytes, error);
    }
    /// True where send_file() can be called: the system moves a file's bytes without a copy.
    [[nodiscard]] virtual bool can_send_file() const { return false; }
    /// Sends some of the file's bytes; 0 without an error where the file ends before `offset`.
    virtual asio::awaitable<std::size_t> send_file(int file, std::uint64_t offset, std::size_t count,
                                                   error_code& error);
    /// Tells the peer that no more will come; it may still be read from.
    virtual asio::awaitable<void> finish() = 0;
    /// Ends what is being waited for, with operation_aborted.
    virtual void cancel() = 0;
    virtual void close() = 0;
};

class TcpCarrier final : public Carrier {
 public:
    explicit TcpCarrier(Socket socket);
    Strand strand() override { return socket_.get_executor(); }
    asio::awaitable<void> handshake(error_code& error) override;
    asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) override;
    asio::awaitable<std::size_t> write(asio::const_buffer bytes, error_code& error) override;
    asio::awaitable<std::size_t> write_before_more(asio::const_buffer bytes, error_code& error) override;
    bool can_send_file() const override { return true; }
    asio::awaitable<std::size_t> send_file(int file, std::uint64_t offset, std::size_t count,
                                           error_code& error) override;
    asio::awaitable<void> finish() override;
    void cancel() override;
    void close() override;
    Socket& stream() { return socket_; }

 private:
    asio::awaitable<std::size_t> send(asio::const_buffer bytes, int flags, error_code& error);
    template <typename Call>
    asio::awaitable<std::size_t> move_out(Call call, error_code& error);
    bool is_long_turn(std::size_t sent);

    Socket socket_;
    std::size_t sent_in_a_row_ = 0;  // without having waited
};

class TlsCarrier final : public Carrier {
 public:
    /// `tls` outlives the carrier.
    TlsCarrier(Socket socket, asio::ssl::context& tls) : stream_(std::move(socket), tls) {}
    Strand strand() override { return stream_.next_layer().get_executor(); }
    asio::awaitable<void> handshake(error_code& error) override;
    asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) override;
    asio::awaitable<std::size_t> write(asio::const_buffer bytes, error_code& error) override;
    asio::awaitable<void> finish() override;
    void cancel() override;
    void close() override;
    TlsStream& stream() { return stream_; }

 private:
    TlsStream stream_;
};

/// TLS where there is a context, plain TCP else.
std::unique_ptr<Carrier> make_carrier(Socket socket, asio::ssl::context* tls);

}  // namespace mvw::server
