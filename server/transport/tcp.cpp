#include "server/transport/tcp.h"

#include <utility>  // before Asio, which uses std::exchange without it

#include <fmt/format.h>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/use_awaitable.hpp>

#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <unordered_map>

#include "server/session.h"

namespace mvw::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Strand = asio::strand<asio::io_context::executor_type>;
using Socket = asio::basic_stream_socket<tcp, Strand>;
using Timer = asio::basic_waitable_timer<Clock, asio::wait_traits<Clock>, Strand>;

constexpr std::size_t kReadBytes = 4096;         // clients send little
constexpr std::size_t kWriteBytes = 128u << 10;  // gathered for one write
constexpr std::chrono::seconds kLinger{1};       // for the peer to read our last words

auto into(error_code& error) {
    return asio::redirect_error(asio::use_awaitable, error);
}

/// One connection: three coroutines on one strand (reader, writer, timer) around one session.
class Peer : public std::enable_shared_from_this<Peer> {
 public:
    Peer(Socket socket, const PeerContext& context, std::string name, std::function<void(Peer*)> on_end)
        : socket_(std::move(socket)),
          timer_(socket_.get_executor()),
          wake_(socket_.get_executor()),
          context_(context),
          session_(context.open, context.limits),
          name_(std::move(name)),
          on_end_(std::move(on_end)) {}

    [[nodiscard]] Strand strand() { return socket_.get_executor(); }

    void start() {
        perform(session_.on_start(Clock::now()));
        const auto self = shared_from_this();
        asio::co_spawn(
            strand(), [self] { return self->read_loop(); }, asio::detached);
        asio::co_spawn(
            strand(), [self] { return self->write_loop(); }, asio::detached);
        asio::co_spawn(
            strand(), [self] { return self->timer_loop(); }, asio::detached);
    }
    void drain() { perform(session_.on_drain(Clock::now())); }
    void end(const std::string& reason) {
        if (std::exchange(ended_, true)) return;
        error_code ignored;
        socket_.close(ignored);
        timer_.cancel();
        wake_.cancel();
        log_end(close_reason_.empty() ? reason : close_reason_);
        on_end_(this);
    }

 private:
    asio::awaitable<void> read_loop() {
        std::array<std::byte, kReadBytes> buffer;
        while (!ended_) {
            error_code error;
            const std::size_t n = co_await socket_.async_read_some(asio::buffer(buffer), into(error));
            if (error) {
                end(error == asio::error::eof ? "peer left" : error.message());
                co_return;
            }
            perform(session_.on_bytes(ByteSpan(buffer.data(), n), Clock::now()));
        }
    }

    asio::awaitable<void> write_loop() {
        while (!ended_) {
            if (queue_.empty()) {
                if (closing_) {
                    linger();
                    co_return;
                }
                out_ = {};  // an idle peer costs no buffer
                wake_.expires_at(Clock::time_point::max());
                error_code ignored;
                co_await wake_.async_wait(into(ignored));
                continue;
            }
            gather();
            if (!co_await write_out()) co_return;
        }
    }

    asio::awaitable<bool> write_out() {
        for (std::size_t done = 0; done < out_.size() && !ended_;) {
            error_code error;
            const std::size_t n =
                co_await socket_.async_write_some(asio::buffer(out_.data() + done, out_.size() - done), into(error));
            if (error) {
                end(error.message());
                co_return false;
            }
            done += n;
            perform(session_.on_sent(n, Clock::now()));
        }
        co_return !ended_;
    }

    asio::awaitable<void> timer_loop() {
        while (!ended_) {
            timer_.expires_at(due_);
            error_code error;
            co_await timer_.async_wait(into(error));
            if (ended_) co_return;
            if (error || Clock::now() < due_) continue;  // moved
            due_ = Clock::time_point::max();
            if (lingering_)
                end("closed");
            else
                perform(session_.on_timer(Clock::now()));
        }
    }

    void perform(Actions actions) {
        for (Action& action : actions) {
            if (auto* bytes = std::get_if<SendBytes>(&action)) {
                queue_.emplace_back(std::move(bytes->bytes));
            } else if (auto* range = std::get_if<SendRange>(&action)) {
                queue_.emplace_back(std::move(*range));
            } else if (const auto* timer = std::get_if<SetTimer>(&action)) {
                due_ = timer->at;
                timer_.cancel();
            } else {
                closing_ = true;
                close_reason_ = std::get<Close>(action).reason;
                due_ = Clock::now() + context_.limits.stall_time;  // for what is queued to be taken
                lingering_ = true;
                timer_.cancel();
            }
        }
        if (!queue_.empty() || closing_) wake_.cancel();
    }

    // Moves what is queued into out_, up to one write's worth. Files are read here and not earlier.
    void gather() {
        out_.clear();
        while (!queue_.empty() && out_.size() < kWriteBytes) {
            if (const auto* bytes = std::get_if<Bytes>(&queue_.front())) {
                out_.insert(out_.end(), bytes->begin(), bytes->end());
                queue_.pop_front();
            } else if (!gather_range(std::get<SendRange>(queue_.front()))) {
                return;
            }
        }
    }

    bool gather_range(SendRange& range) {
        const std::size_t at = out_.size();
        const auto n = static_cast<std::uint32_t>(std::min<std::size_t>(range.length, kWriteBytes));
        out_.resize(at + n);
        if (Result<void> r = range.model->read(range.offset, std::span(out_).subspan(at)); !r) {
            out_.resize(at);
            queue_.clear();
            perform(session_.on_read_error(r.error()));
            return false;
        }
        range.offset += n;
        range.length -= n;
        if (range.length == 0) queue_.pop_front();
        return true;
    }

    // Says that no more will come and gives the peer a moment to read it: closing at once could take our last words
    // back.
    void linger() {
        error_code ignored;
        socket_.shutdown(tcp::socket::shutdown_send, ignored);
        due_ = Clock::now() + kLinger;
        timer_.cancel();
    }

    void log_end(const std::string& reason) const {
        const SessionStats& s = session_.stats();
        context_.log(LogLevel::Info,
                     fmt::format("event=closed peer={} model={} requests={} chunks={} bytes={} errors={} reason={}",
                                 name_, log_value(session_.model_name()), s.requests, s.chunks, s.queued_bytes,
                                 s.errors, log_value(reason)));
    }

    Socket socket_;
    Timer timer_, wake_;
    const PeerContext& context_;
    Session session_;
    std::string name_;
    std::function<void(Peer*)> on_end_;
    std::deque<std::variant<Bytes, SendRange>> queue_;
    Bytes out_;
    Clock::time_point due_ = Clock::time_point::max();
    bool closing_ = false, lingering_ = false, ended_ = false;
    std::string close_reason_;
};

}  // namespace

class TcpListener::Impl : public std::enable_shared_from_this<TcpListener::Impl> {
 public:
    Impl(asio::io_context& io, const PeerContext& context)
        : io_(io), strand_(io.get_executor()), acceptor_(strand_), retry_(strand_), context_(context) {}

    Result<protocol::HostPort> listen(const protocol::HostPort& address) {
        error_code error;
        tcp::resolver resolver(io_);
        const auto found = resolver.resolve(address.host, std::to_string(address.port), tcp::resolver::passive, error);
        if (error) return io_error(address, error);
        const tcp::endpoint endpoint = *found.begin();
        acceptor_.open(endpoint.protocol(), error);
        if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
        if (!error) acceptor_.bind(endpoint, error);
        if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
        if (error) return io_error(address, error);
        const tcp::endpoint bound = acceptor_.local_endpoint(error);
        const auto self = shared_from_this();
        asio::co_spawn(
            strand_, [self] { return self->accept_loop(); }, asio::detached);
        return protocol::HostPort{bound.address().to_string(), bound.port()};
    }

    void drain() {
        asio::post(strand_, [self = shared_from_this()] {
            self->stop_accepting();
            for (const auto& [key, peer] : self->peers_) asio::post(peer->strand(), [p = peer] { p->drain(); });
        });
    }
    void stop() {
        asio::post(strand_, [self = shared_from_this()] {
            self->stop_accepting();
            for (const auto& [key, peer] : self->peers_)
                asio::post(peer->strand(), [p = peer] { p->end("server stopped"); });
        });
    }
    [[nodiscard]] std::size_t connections() const { return connections_; }

 private:
    static Error io_error(const protocol::HostPort& address, const error_code& error) {
        return {Errc::Io, 0, "cannot listen on " + to_string(address) + ": " + error.message()};
    }

    asio::awaitable<void> accept_loop() {
        while (acceptor_.is_open()) {
            Socket socket{Strand(io_.get_executor())};
            tcp::endpoint from;
            error_code error;
            co_await acceptor_.async_accept(socket, from, into(error));
            if (!acceptor_.is_open()) co_return;
            if (error) {  // out of descriptors, or the peer has gone already
                context_.log(LogLevel::Warning, "event=accept_failed reason=" + log_value(error.message()));
                retry_.expires_after(std::chrono::milliseconds(100));
                co_await retry_.async_wait(into(error));
                continue;
            }
            admit(std::move(socket), from);
        }
    }

    void admit(Socket socket, const tcp::endpoint& from) {
        std::size_t& of_address = per_address_[from.address()];
        if (connections_ >= context_.limits.max_connections ||
            of_address >= context_.limits.max_connections_per_address) {
            if (of_address == 0) per_address_.erase(from.address());
            return refuse(std::move(socket));
        }
        ++of_address;
        ++connections_;
        error_code ignored;
        socket.set_option(tcp::no_delay(true), ignored);
        const auto on_end = [self = shared_from_this(), address = from.address()](Peer* peer) {
            asio::post(self->strand_, [self, address, peer] { self->release(address, peer); });
        };
        const auto peer =
            std::make_shared<Peer>(std::move(socket), context_,
                                   to_string(protocol::HostPort{from.address().to_string(), from.port()}), on_end);
        peers_.emplace(peer.get(), peer);
        asio::post(peer->strand(), [peer] { peer->start(); });
    }

    // One try to say why: a peer that is over the limit is given no buffer and no time.
    void refuse(Socket socket) {
        const Bytes message =
            write_message(protocol::ErrorMessage{protocol::ErrorCode::TooBusy, "too many connections"});
        error_code ignored;
        socket.non_blocking(true, ignored);
        socket.write_some(asio::buffer(message), ignored);
        context_.log(LogLevel::Warning, "event=refused reason=\"too many connections\"");
    }

    void release(const asio::ip::address& address, Peer* peer) {
        peers_.erase(peer);
        --connections_;
        if (const auto it = per_address_.find(address); it != per_address_.end() && --it->second == 0)
            per_address_.erase(it);
    }

    void stop_accepting() {
        error_code ignored;
        acceptor_.close(ignored);
        retry_.cancel();
    }

    asio::io_context& io_;
    Strand strand_;
    asio::basic_socket_acceptor<tcp, Strand> acceptor_;
    Timer retry_;
    const PeerContext& context_;
    std::unordered_map<Peer*, std::shared_ptr<Peer>> peers_;
    std::map<asio::ip::address, std::size_t> per_address_;
    std::atomic<std::size_t> connections_ = 0;
};

TcpListener::TcpListener(asio::io_context& io, const PeerContext& context)
    : impl_(std::make_shared<Impl>(io, context)) {}
TcpListener::~TcpListener() = default;
Result<protocol::HostPort> TcpListener::listen(const protocol::HostPort& address) {
    return impl_->listen(address);
}
void TcpListener::drain() {
    impl_->drain();
}
void TcpListener::stop() {
    impl_->stop();
}
std::size_t TcpListener::connections() const {
    return impl_->connections();
}

}  // namespace mvw::server
