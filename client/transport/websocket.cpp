// WebSocket (RFC 6455) as a wire: the native protocol's bytes in binary messages.
#include "client/transport/wire.h"

#include <boost/beast/http/field.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>

namespace mvw::client {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr const char* kPath = "/stream";  // PROTOCOL.md 2
constexpr const char* kSubprotocol = "mvw.1";

/// Lower: tcp::socket or TlsStream.
template <typename Lower>
class WebSocketWire final : public Wire {
 public:
    template <typename... More>
    WebSocketWire(asio::io_context& io, const Url& url, More&... more)
        : url_(url), resolver_(io), stream_(io, more...) {}

    asio::awaitable<void> connect(error_code& error) override {
        if constexpr (std::is_same_v<Lower, TlsStream>)
            co_await connect_tls(resolver_, stream_.next_layer(), url_, error);
        else
            co_await connect_socket(resolver_, stream_.next_layer(), url_, error);
        if (error) co_return;
        stream_.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
            request.set(beast::http::field::sec_websocket_protocol, kSubprotocol);
        }));
        stream_.auto_fragment(false);
        stream_.binary(true);
        stream_.read_message_max(0);  // only the row of bytes counts, and the session bounds that
        const std::string host = to_string(url_.address);
        co_await stream_.async_handshake(host, kPath, into(error));
    }
    asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) override {
        std::size_t n = 0;
        while (!error && n == 0) n = co_await stream_.async_read_some(out, into(error));
        if (error == websocket::error::closed) error = asio::error::eof;
        co_return n;
    }
    asio::awaitable<void> write(asio::const_buffer bytes, error_code& error) override {
        co_await stream_.async_write(bytes, into(error));
    }
    void close() override {
        resolver_.cancel();
        error_code ignored;
        beast::get_lowest_layer(stream_).close(ignored);
    }

 private:
    const Url url_;
    tcp::resolver resolver_;
    websocket::stream<Lower> stream_;
};

}  // namespace

std::unique_ptr<Wire> make_websocket(asio::io_context& io, const Url& url, asio::ssl::context* tls) {
    if (url.tls) return std::make_unique<WebSocketWire<TlsStream>>(io, url, *tls);
    return std::make_unique<WebSocketWire<tcp::socket>>(io, url);
}

}  // namespace mvw::client
