// One connection to a server, whatever wraps it: TCP, TLS, or WebSocket on either. Inside the transport folder only.
#pragma once
#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/use_awaitable.hpp>

#include <memory>
#include <string>

#include "client/url.h"

namespace mvw::client {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using TlsStream = asio::ssl::stream<tcp::socket>;

/// For co_await: errors into a variable instead of an exception.
inline auto into(error_code& error) {
    return asio::redirect_error(asio::use_awaitable, error);
}

/// Bytes in both directions, on one thread. One read and one write may be under way together; an orderly end by the
/// server is asio::error::eof.
class Wire {
 public:
    virtual ~Wire() = default;
    /// Finds the host, connects, and agrees on what is needed before the first byte.
    virtual asio::awaitable<void> connect(error_code& error) = 0;
    virtual asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) = 0;
    /// Takes all of the bytes.
    virtual asio::awaitable<void> write(asio::const_buffer bytes, error_code& error) = 0;
    virtual void close() = 0;
};

/// TLS for a client: 1.2 or 1.3, the server's certificate checked against `ca_file`, or against the system's where
/// that is empty. Io where the file cannot be read.
Result<std::unique_ptr<asio::ssl::context>> make_client_tls(const std::string& ca_file);

/// The wire that a URL asks for, not yet connected; mvw and http URLs have TCP, ws URLs WebSocket on it. `tls` outlives
/// the wire and is used where url.tls says so.
std::unique_ptr<Wire> make_wire(asio::io_context& io, const Url& url, asio::ssl::context* tls);

/// Connects a socket to the URL's host and port.
asio::awaitable<void> connect_socket(tcp::resolver& resolver, tcp::socket& socket, const Url& url, error_code& error);
/// The same with a TLS handshake behind it.
asio::awaitable<void> connect_tls(tcp::resolver& resolver, TlsStream& stream, const Url& url, error_code& error);

/// Of websocket.cpp, which alone sees Beast's WebSocket.
std::unique_ptr<Wire> make_websocket(asio::io_context& io, const Url& url, asio::ssl::context* tls);

}  // namespace mvw::client
