#include "server/origin/http_client.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/vector_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>

#include <algorithm>
#include <charconv>
#include <vector>

namespace mvw::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using boost::system::error_code;
using Parser = http::response_parser<http::vector_body<std::byte>>;
using Request = http::request<http::empty_body>;

constexpr std::chrono::seconds kAnswerTime{
    8};  // for one attempt, whole; three of them stay below the peers' stall time
constexpr int kAttempts = 3;
constexpr std::chrono::milliseconds kPause{200};     // before the second attempt; twice that before the third
constexpr std::uint64_t kMaxErrorBytes = 64u << 10;  // of the text that comes with a refusal
constexpr std::uint32_t kMaxHeadBytes = 32u << 10;

auto into(error_code& error) {
    return asio::redirect_error(asio::use_awaitable, error);
}

/// TCP, or TLS on it.
struct Connection {
    std::string to;  // address and scheme
    std::unique_ptr<beast::tcp_stream> plain;
    std::unique_ptr<beast::ssl_stream<beast::tcp_stream>> secure;
    beast::flat_buffer buffer;
    bool used = false;  // has brought an answer

    beast::tcp_stream& tcp() { return plain ? *plain : beast::get_lowest_layer(*secure); }
};

std::string text_of(const Parser::value_type& answer, http::field field) {
    const auto value = answer[field];
    return {value.data(), value.size()};
}

// "bytes 5-9/698". False where it is anything else.
bool read_content_range(std::string_view text, std::uint64_t& first, std::uint64_t& file_bytes) {
    constexpr std::string_view kUnit = "bytes ";
    const std::size_t slash = text.find('/');
    if (!text.starts_with(kUnit) || slash == std::string_view::npos) return false;
    const char* const end = text.data() + text.size();
    const auto a = std::from_chars(text.data() + kUnit.size(), end, first);
    const auto b = std::from_chars(text.data() + slash + 1, end, file_bytes);
    return a.ec == std::errc{} && b.ec == std::errc{} && b.ptr == end;
}

std::string validator_of(const Parser::value_type& answer) {
    std::string tag = text_of(answer, http::field::etag);
    return tag.empty() || tag.starts_with("W/") ? text_of(answer, http::field::last_modified) : tag;
}

// Answers that pass by themselves.
bool is_temporary(unsigned status) {
    return status == 408 || status == 429 || status >= 500;
}

Request request_of(const StoreUrl& url, std::uint64_t first, std::uint64_t last, const std::string& unless) {
    Request request{http::verb::get, url.target, 11};
    std::string host = to_string(url.address);
    if (url.address.port == (url.tls ? 443 : 80)) host.resize(host.rfind(':'));  // signatures are over the short form
    request.set(http::field::host, host);
    request.set(http::field::user_agent, "mvw");
    request.set(http::field::range, "bytes=" + std::to_string(first) + "-" + std::to_string(last));
    if (unless.starts_with('"'))
        request.set(http::field::if_none_match, unless);
    else if (!unless.empty())
        request.set(http::field::if_modified_since, unless);
    return request;
}

}  // namespace

class HttpClient::Impl {
 public:
    Impl(asio::io_context& io, std::size_t max_connections)
        : io_(io), tls_(asio::ssl::context::tls_client), free_(io), max_connections_(max_connections) {
        free_.expires_at(asio::steady_timer::time_point::max());
    }

    Result<void> trust(const std::string& ca_file) {
        error_code error;
        tls_.set_verify_mode(asio::ssl::verify_peer, error);
        if (ca_file.empty())
            tls_.set_default_verify_paths(error);
        else
            tls_.load_verify_file(ca_file, error);
        if (error) return Error{Errc::Io, 0, (ca_file.empty() ? "certificates" : ca_file) + ": " + error.message()};
        return {};
    }

    asio::awaitable<Result<RangeAnswer>> get(StoreUrl url, std::uint64_t first, std::uint64_t last,
                                             std::string unless) {
        co_await take_place();
        const Request request = request_of(url, first, last, unless);
        const std::uint64_t most = last - first + 1;
        Result<RangeAnswer> answer = Error{};
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            if (attempt > 0) co_await pause(kPause * attempt);
            answer = co_await attempt_once(url, request, most);
            if (answer.ok() && is_temporary(answer->status))
                answer = Error{Errc::Io, 0, "the store answers " + std::to_string(answer->status)};
            if (answer.ok() || answer.error().code != Errc::Io) break;
        }
        if (answer.ok() && answer->status == 206 && answer->first != first)
            answer = Error{Errc::Malformed, 0, "the store sends another range than it was asked for"};
        --busy_;
        free_.cancel_one();
        co_return answer;
    }

 private:
    using ConnectionPtr = std::unique_ptr<Connection>;

    asio::awaitable<void> take_place() {
        error_code ignored;
        while (busy_ >= max_connections_) co_await free_.async_wait(into(ignored));
        ++busy_;
    }

    asio::awaitable<void> pause(std::chrono::milliseconds time) {
        asio::steady_timer timer(io_, time);
        error_code ignored;
        co_await timer.async_wait(into(ignored));
    }

    // A connection that was kept may have been closed by the store meanwhile, which is its right: then a new one.
    asio::awaitable<Result<RangeAnswer>> attempt_once(const StoreUrl& url, const Request& request, std::uint64_t most) {
        const std::string to = (url.tls ? "s" : "p") + to_string(url.address);
        error_code error;
        while (true) {
            ConnectionPtr connection = kept(to);
            if (!connection) {
                connection = fresh(to, url);
                co_await connect(*connection, url, error);
                if (error) co_return Error{Errc::Io, 0, "cannot connect to the store: " + error.message()};
            }
            Parser parser;
            parser.header_limit(kMaxHeadBytes);
            co_await exchange(*connection, request, parser, most, error);
            if (error && error != beast::error::timeout && connection->used && !parser.got_some()) continue;
            if (error == http::error::body_limit) co_return Error{Errc::Unsupported, 0, "the store ignores Range"};
            if (error) co_return Error{Errc::Io, 0, "the store's answer broke off: " + error.message()};
            Result<RangeAnswer> answer = read(parser.get());
            if (parser.keep_alive()) keep(std::move(connection));
            co_return answer;
        }
    }

    ConnectionPtr kept(const std::string& to) {
        const auto found = std::find_if(kept_.rbegin(), kept_.rend(), [&](const auto& c) { return c->to == to; });
        if (found == kept_.rend()) return nullptr;
        ConnectionPtr connection = std::move(*found);
        kept_.erase(std::next(found).base());
        return connection;
    }

    void keep(ConnectionPtr connection) {
        connection->used = true;
        connection->tcp().expires_never();
        kept_.push_back(std::move(connection));
        if (kept_.size() > max_connections_) kept_.erase(kept_.begin());
    }

    ConnectionPtr fresh(const std::string& to, const StoreUrl& url) {
        auto connection = std::make_unique<Connection>();
        connection->to = to;
        if (url.tls)
            connection->secure = std::make_unique<beast::ssl_stream<beast::tcp_stream>>(io_, tls_);
        else
            connection->plain = std::make_unique<beast::tcp_stream>(io_);
        return connection;
    }

    asio::awaitable<void> connect(Connection& c, const StoreUrl& url, error_code& error) {
        asio::ip::tcp::resolver resolver(io_);
        const std::string port = std::to_string(url.address.port);
        const auto found = co_await resolver.async_resolve(url.address.host, port, into(error));
        if (error) co_return;
        c.tcp().expires_after(kAnswerTime);
        co_await c.tcp().async_connect(found, into(error));
        if (error) co_return;
        c.tcp().socket().set_option(asio::ip::tcp::no_delay(true), error);
        if (!c.secure) co_return;
        c.secure->set_verify_callback(asio::ssl::host_name_verification(url.address.host), error);
        SSL_set_tlsext_host_name(c.secure->native_handle(), url.address.host.c_str());
        co_await c.secure->async_handshake(asio::ssl::stream_base::client, into(error));
    }

    asio::awaitable<void> exchange(Connection& c, const Request& request, Parser& parser, std::uint64_t most,
                                   error_code& error) {
        c.tcp().expires_after(kAnswerTime);
        if (c.plain)
            co_await exchange_over(*c.plain, c.buffer, request, parser, most, error);
        else
            co_await exchange_over(*c.secure, c.buffer, request, parser, most, error);
    }

    template <typename Stream>
    static asio::awaitable<void> exchange_over(Stream& stream, beast::flat_buffer& buffer, const Request& request,
                                               Parser& parser, std::uint64_t most, error_code& error) {
        co_await http::async_write(stream, request, into(error));
        if (error) co_return;
        co_await http::async_read_header(stream, buffer, parser, into(error));
        if (error) co_return;
        const unsigned status = parser.get().result_int();
        parser.body_limit(status == 206 || status == 200 ? most : kMaxErrorBytes);
        if (const auto length = parser.content_length(); length && status == 200 && *length > most)
            error = http::error::body_limit;
        else
            co_await http::async_read(stream, buffer, parser, into(error));
    }

    static Result<RangeAnswer> read(Parser::value_type& message) {
        RangeAnswer answer;
        answer.status = message.result_int();
        answer.validator = validator_of(message);
        answer.body = std::move(message.body());
        if (answer.status == 200) {  // all of a file no larger than what was asked for
            answer.status = 206;
            answer.file_bytes = answer.body.size();
        } else if (answer.status == 206 &&
                   !read_content_range(text_of(message, http::field::content_range), answer.first, answer.file_bytes)) {
            return Error{Errc::Malformed, 0, "the store's Content-Range cannot be read"};
        }
        return answer;
    }

    asio::io_context& io_;
    asio::ssl::context tls_;
    asio::steady_timer free_;  // those who wait for a place
    const std::size_t max_connections_;
    std::size_t busy_ = 0;
    std::vector<ConnectionPtr> kept_;  // not busy; the one used last is last
};

Result<std::unique_ptr<HttpClient>> HttpClient::make(asio::io_context& io, const std::string& ca_file,
                                                     std::size_t max_connections) {
    auto impl = std::make_unique<Impl>(io, max_connections);
    if (Result<void> r = impl->trust(ca_file); !r) return r.error();
    return std::unique_ptr<HttpClient>(new HttpClient(std::move(impl)));
}

HttpClient::HttpClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HttpClient::~HttpClient() = default;

asio::awaitable<Result<RangeAnswer>> HttpClient::get(StoreUrl url, std::uint64_t first, std::uint64_t last,
                                                     std::string unless) {
    return impl_->get(std::move(url), first, last, std::move(unless));
}

}  // namespace mvw::server
