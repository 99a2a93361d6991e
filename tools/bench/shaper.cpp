#include "tools/bench/shaper.h"

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <atomic>
#include <deque>
#include <random>
#include <set>
#include <thread>

#include "codec/bytes.h"

namespace mvw::bench {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kPieceBytes = 1460;      // a packet's worth: what is paced and delayed as one
constexpr std::size_t kQueueBytes = 1u << 20;  // on the way in one direction before the sender is held up

auto into(error_code& error) {
    return asio::redirect_error(asio::use_awaitable, error);
}

/// One direction of one connection: pieces on their way, each with the time at which it arrives.
struct Pipe {
    explicit Pipe(asio::io_context& io) : moved(io, Clock::time_point::max()) {}
    std::deque<std::pair<Clock::time_point, Bytes>> pieces;
    std::size_t bytes = 0;
    bool ended = false;            // nothing more will enter
    Clock::time_point free_at{};   // the link has sent what entered before
    Clock::time_point last_out{};  // pieces do not overtake each other
    asio::steady_timer moved;      // cancelled whenever something entered or left
};

struct Pair {
    explicit Pair(asio::io_context& io, tcp::socket c)
        : client(std::move(c)), server(io), up(io), down(io), begun(Clock::now()) {}
    void close() {
        error_code ignored;
        client.close(ignored);
        server.close(ignored);
        up.moved.cancel();
        down.moved.cancel();
        open = false;
    }
    tcp::socket client, server;
    Pipe up, down;
    Clock::time_point begun;
    std::uint64_t to_client = 0;
    bool open = true;
};
using PairPtr = std::shared_ptr<Pair>;

}  // namespace

class Shaper::Impl {
 public:
    Impl(const protocol::HostPort& target, const LinkShape& shape) : target_(target), shape_(shape), acceptor_(io_) {}
    ~Impl() {
        if (!thread_.joinable()) return;
        asio::post(io_, [this] {
            stopped_ = true;
            error_code ignored;
            acceptor_.close(ignored);
            for (const PairPtr& pair : pairs_) pair->close();
            io_.stop();
        });
        thread_.join();
    }

    Result<void> start() {
        error_code error;
        const tcp::endpoint any(asio::ip::address_v4::loopback(), 0);
        acceptor_.open(any.protocol(), error);
        if (!error) acceptor_.bind(any, error);
        if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
        if (error) return Error{Errc::Io, 0, "the shaper cannot listen: " + error.message()};
        port_ = acceptor_.local_endpoint(error).port();
        asio::co_spawn(
            io_, [this] { return accept_loop(); }, asio::detached);
        thread_ = std::thread([this] { io_.run(); });
        return {};
    }

    [[nodiscard]] protocol::HostPort address() const { return {"127.0.0.1", port_}; }
    std::atomic<std::uint64_t> to_clients_ = 0, connections_ = 0;

 private:
    asio::awaitable<void> accept_loop() {
        while (!stopped_) {
            tcp::socket client(io_);
            error_code error;
            co_await acceptor_.async_accept(client, into(error));
            if (error) co_return;
            ++connections_;
            client.set_option(tcp::no_delay(true), error);
            auto pair = std::make_shared<Pair>(io_, std::move(client));
            pairs_.insert(pair);
            asio::co_spawn(
                io_, [this, pair] { return run(pair); }, asio::detached);
        }
    }

    asio::awaitable<void> run(PairPtr pair) {
        error_code error;
        const tcp::endpoint target(asio::ip::make_address(target_.host, error), target_.port);
        if (!error) co_await pair->server.async_connect(target, into(error));
        if (error) {
            pair->close();
            pairs_.erase(pair);
            co_return;
        }
        pair->server.set_option(tcp::no_delay(true), error);
        asio::co_spawn(
            io_, [this, pair] { return fill(pair, pair->client, pair->up, true); }, asio::detached);
        asio::co_spawn(
            io_, [this, pair] { return drain(pair, pair->server, pair->up, false); }, asio::detached);
        asio::co_spawn(
            io_, [this, pair] { return fill(pair, pair->server, pair->down, false); }, asio::detached);
        asio::co_spawn(
            io_, [this, pair] { return drain(pair, pair->client, pair->down, true); }, asio::detached);
    }

    // From a socket onto the link.
    asio::awaitable<void> fill(PairPtr pair, tcp::socket& from, Pipe& pipe, bool is_up) {
        while (pair->open) {
            error_code error;
            if (pipe.bytes >= kQueueBytes) {
                co_await pipe.moved.async_wait(into(error));
                continue;
            }
            Bytes piece(kPieceBytes);
            const std::size_t n = co_await from.async_read_some(asio::buffer(piece), into(error));
            if (error) break;
            piece.resize(n);
            const Clock::time_point arrival = arrival_of(*pair, pipe, n, is_up);
            pipe.bytes += n;
            pipe.pieces.emplace_back(arrival, std::move(piece));
            pipe.moved.cancel();
        }
        pipe.ended = true;
        pipe.moved.cancel();
    }

    // When n bytes that enter now come out.
    Clock::time_point arrival_of(const Pair& pair, Pipe& pipe, std::size_t n, bool is_up) {
        Clock::time_point enters = Clock::now();
        if (is_up) enters = std::max(enters, pair.begun + shape_.round_trip);  // the handshake's
        pipe.free_at = std::max(pipe.free_at, enters);
        if (shape_.megabits_per_second > 0)
            pipe.free_at += std::chrono::nanoseconds(
                static_cast<std::int64_t>(static_cast<double>(n) * 8000 / shape_.megabits_per_second));
        if (shape_.stall_every.count() > 0) {  // nothing enters the link meanwhile, either
            const auto age = std::chrono::duration_cast<std::chrono::milliseconds>(pipe.free_at - pair.begun);
            const auto into_period = age % (shape_.stall_every + shape_.stall_time);
            if (into_period > shape_.stall_every) pipe.free_at += shape_.stall_every + shape_.stall_time - into_period;
        }
        Clock::time_point out = pipe.free_at + shape_.round_trip / 2;
        if (shape_.jitter.count() > 0)
            out += std::chrono::milliseconds(random_() % static_cast<unsigned>(shape_.jitter.count() + 1));
        return pipe.last_out = std::max(pipe.last_out, out);
    }

    // From the link into a socket.
    asio::awaitable<void> drain(PairPtr pair, tcp::socket& to, Pipe& pipe, bool is_down) {
        asio::steady_timer timer(io_);
        while (pair->open) {
            error_code error;
            if (pipe.pieces.empty()) {
                if (pipe.ended) break;
                co_await pipe.moved.async_wait(into(error));
                continue;
            }
            timer.expires_at(pipe.pieces.front().first);
            co_await timer.async_wait(into(error));
            if (!pair->open) break;
            const Bytes piece = std::move(pipe.pieces.front().second);
            pipe.pieces.pop_front();
            pipe.bytes -= piece.size();
            pipe.moved.cancel();
            co_await asio::async_write(to, asio::buffer(piece), into(error));
            if (error) break;
            if (is_down && count(*pair, piece.size())) break;
        }
        if (pair->open && pipe.ended && pipe.pieces.empty()) {
            error_code ignored;
            to.shutdown(tcp::socket::shutdown_send, ignored);
            if (!pair->up.ended || !pair->down.ended) co_return;  // the other direction goes on
        }
        pair->close();
        pairs_.erase(pair);
    }

    // True where the connection is to be reset now.
    bool count(Pair& pair, std::size_t n) {
        to_clients_ += n;
        pair.to_client += n;
        if (shape_.reset_after_bytes == 0 || pair.to_client < shape_.reset_after_bytes) return false;
        error_code ignored;
        pair.client.set_option(asio::socket_base::linger(true, 0), ignored);
        return true;
    }

    const protocol::HostPort target_;
    const LinkShape shape_;
    asio::io_context io_;
    tcp::acceptor acceptor_;
    std::uint16_t port_ = 0;
    std::set<PairPtr> pairs_;
    std::minstd_rand random_{1};
    bool stopped_ = false;
    std::thread thread_;
};

Result<std::unique_ptr<Shaper>> Shaper::start(const protocol::HostPort& target, const LinkShape& shape) {
    auto impl = std::make_unique<Impl>(target, shape);
    if (Result<void> r = impl->start(); !r) return r.error();
    return std::unique_ptr<Shaper>(new Shaper(std::move(impl)));
}

Shaper::Shaper(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Shaper::~Shaper() = default;
protocol::HostPort Shaper::address() const {
    return impl_->address();
}
std::uint64_t Shaper::bytes_to_clients() const {
    return impl_->to_clients_;
}
std::uint64_t Shaper::connections() const {
    return impl_->connections_;
}

}  // namespace mvw::bench
