#include "server/transport/websocket.h"

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>

namespace mvw::server {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

http::request<http::empty_body> as_beast(const UpgradeRequest& r) {
    http::request<http::empty_body> request{http::verb::get, r.target, 11};
    request.set(http::field::host, r.host);
    request.set(http::field::connection, "Upgrade");
    request.set(http::field::upgrade, "websocket");
    request.set(http::field::sec_websocket_key, r.key);
    request.set(http::field::sec_websocket_version, r.version);
    return request;
}

template <typename Lower>
Socket& socket_of(Lower& lower) {
    if constexpr (std::is_same_v<Lower, Socket>)
        return lower;
    else
        return lower.next_layer();
}

/// Lower: Socket or TlsStream.
template <typename Lower>
class WebSocketCarrier final : public Carrier {
 public:
    WebSocketCarrier(Lower lower, UpgradeRequest request, const ServerLimits& limits)
        : stream_(std::move(lower)), request_(std::move(request)) {
        websocket::stream_base::timeout timeout{};
        timeout.handshake_timeout = limits.header_time;
        timeout.idle_timeout = websocket::stream_base::none();  // the session has its own
        timeout.keep_alive_pings = false;
        stream_.set_option(timeout);
        stream_.auto_fragment(false);
        stream_.binary(true);
        stream_.read_message_max(0);  // only the row of bytes counts, and the session bounds that
    }

    Strand strand() override { return socket_of(stream_.next_layer()).get_executor(); }

    asio::awaitable<void> handshake(error_code& error) override {
        if (request_.protocols.find(kSubprotocol) != std::string::npos)
            stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
                response.set(http::field::sec_websocket_protocol, kSubprotocol);
            }));
        const auto request = as_beast(request_);
        co_await stream_.async_accept(request, into(error));
    }

    asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) override {
        std::size_t n = 0;
        while (!error && n == 0) {  // empty messages carry nothing
            n = co_await stream_.async_read_some(out, into(error));
            if (!error && !stream_.got_binary()) error = websocket::make_error_code(websocket::error::bad_opcode);
        }
        if (error == websocket::error::closed) error = asio::error::eof;
        co_return n;
    }

    asio::awaitable<std::size_t> write(asio::const_buffer bytes, error_code& error) override {
        co_return co_await stream_.async_write(bytes, into(error));
    }

    asio::awaitable<void> finish() override {
        error_code ignored;
        co_await stream_.async_close(websocket::close_code::normal, into(ignored));
    }
    void cancel() override {
        error_code ignored;
        socket_of(stream_.next_layer()).cancel(ignored);
    }
    void close() override {
        error_code ignored;
        socket_of(stream_.next_layer()).close(ignored);
    }

 private:
    websocket::stream<Lower> stream_;
    const UpgradeRequest request_;
};

}  // namespace

std::unique_ptr<Carrier> upgrade(std::unique_ptr<Carrier> below, UpgradeRequest request, const ServerLimits& limits) {
    if (auto* tls = dynamic_cast<TlsCarrier*>(below.get()))
        return std::make_unique<WebSocketCarrier<TlsStream>>(std::move(tls->stream()), std::move(request), limits);
    auto& tcp_carrier = dynamic_cast<TcpCarrier&>(*below);
    return std::make_unique<WebSocketCarrier<Socket>>(std::move(tcp_carrier.stream()), std::move(request), limits);
}

}  // namespace mvw::server
