#include "client/transport/wire.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/write.hpp>

namespace mvw::client {
namespace {

class TcpWire final : public Wire {
 public:
    TcpWire(asio::io_context& io, const Url& url) : url_(url), resolver_(io), socket_(io) {}
    asio::awaitable<void> connect(error_code& error) override {
        co_await connect_socket(resolver_, socket_, url_, error);
    }
    asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) override {
        co_return co_await socket_.async_read_some(out, into(error));
    }
    asio::awaitable<void> write(asio::const_buffer bytes, error_code& error) override {
        co_await asio::async_write(socket_, asio::const_buffers_1(bytes), into(error));
    }
    void close() override {
        resolver_.cancel();
        error_code ignored;
        socket_.close(ignored);
    }

 private:
    const Url url_;
    tcp::resolver resolver_;
    tcp::socket socket_;
};

class TlsWire final : public Wire {
 public:
    TlsWire(asio::io_context& io, const Url& url, asio::ssl::context& tls)
        : url_(url), resolver_(io), stream_(io, tls) {}
    asio::awaitable<void> connect(error_code& error) override { co_await connect_tls(resolver_, stream_, url_, error); }
    asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) override {
        const std::size_t n = co_await stream_.async_read_some(out, into(error));
        if (error == asio::ssl::error::stream_truncated) error = asio::error::eof;  // chunks carry their own checks
        co_return n;
    }
    asio::awaitable<void> write(asio::const_buffer bytes, error_code& error) override {
        co_await asio::async_write(stream_, asio::const_buffers_1(bytes), into(error));
    }
    void close() override {
        resolver_.cancel();
        error_code ignored;
        stream_.next_layer().close(ignored);
    }

 private:
    const Url url_;
    tcp::resolver resolver_;
    TlsStream stream_;
};

}  // namespace

Result<std::unique_ptr<asio::ssl::context>> make_client_tls(const std::string& ca_file) {
    auto tls = std::make_unique<asio::ssl::context>(asio::ssl::context::tls_client);
    error_code error;
    tls->set_options(
        asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1, error);
    tls->set_verify_mode(asio::ssl::verify_peer, error);
    if (ca_file.empty())
        tls->set_default_verify_paths(error);
    else
        tls->load_verify_file(ca_file, error);
    if (error)
        return Error{Errc::Io, 0, (ca_file.empty() ? "the system's certificates" : ca_file) + ": " + error.message()};
    return tls;
}

asio::awaitable<void> connect_socket(tcp::resolver& resolver, tcp::socket& socket, const Url& url, error_code& error) {
    const auto found = co_await resolver.async_resolve(url.address.host, std::to_string(url.address.port), into(error));
    if (error) co_return;
    co_await asio::async_connect(socket, found, into(error));
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
}

asio::awaitable<void> connect_tls(tcp::resolver& resolver, TlsStream& stream, const Url& url, error_code& error) {
    co_await connect_socket(resolver, stream.next_layer(), url, error);
    if (error) co_return;
    SSL_set_tlsext_host_name(stream.native_handle(), url.address.host.c_str());
    stream.set_verify_callback(asio::ssl::host_name_verification(url.address.host), error);
    if (!error) co_await stream.async_handshake(asio::ssl::stream_base::client, into(error));
}

std::unique_ptr<Wire> make_wire(asio::io_context& io, const Url& url, asio::ssl::context* tls) {
    if (url.scheme == Scheme::WebSocket) return make_websocket(io, url, tls);
    if (url.tls) return std::make_unique<TlsWire>(io, url, *tls);
    return std::make_unique<TcpWire>(io, url);
}

}  // namespace mvw::client
