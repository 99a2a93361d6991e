#include "server/transport/listener.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>

namespace mvw::server {
namespace {

Error listen_error(const protocol::HostPort& address, const error_code& error) {
    return {Errc::Io, 0, "cannot listen on " + to_string(address) + ": " + error.message()};
}

}  // namespace

bool Admission::admit(const asio::ip::address& from) {
    const std::lock_guard lock(mutex_);
    if (total_ >= limits_.max_connections) return false;
    const auto [of_address, is_new] = per_address_.try_emplace(from, 0);
    if (of_address->second >= limits_.max_connections_per_address) {
        if (is_new) per_address_.erase(of_address);
        return false;
    }
    ++of_address->second;
    ++total_;
    return true;
}

void Admission::release(const asio::ip::address& from) {
    const std::lock_guard lock(mutex_);
    --total_;
    if (const auto it = per_address_.find(from); it != per_address_.end() && --it->second == 0) per_address_.erase(it);
}

std::size_t Admission::connections() const {
    const std::lock_guard lock(mutex_);
    return total_;
}

Listener::Listener(Workers& workers, const PeerContext& context, Admission& admission, Make make, Bytes refusal)
    : workers_(workers),
      strand_(workers.first().get_executor()),
      acceptor_(strand_),
      retry_(strand_),
      context_(context),
      admission_(admission),
      make_(std::move(make)),
      refusal_(std::move(refusal)) {}

Result<protocol::HostPort> Listener::listen(const protocol::HostPort& address) {
    error_code error;
    tcp::resolver resolver(workers_.first());
    const auto found = resolver.resolve(address.host, std::to_string(address.port), tcp::resolver::passive, error);
    if (error) return listen_error(address, error);
    const tcp::endpoint endpoint = *found.begin();
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error) return listen_error(address, error);
    const tcp::endpoint bound = acceptor_.local_endpoint(error);
    asio::co_spawn(
        strand_, [self = shared_from_this()] { return self->accept_loop(); }, asio::detached);
    return protocol::HostPort{bound.address().to_string(), bound.port()};
}

void Listener::drain() {
    asio::post(strand_, [self = shared_from_this()] {
        self->stop_accepting();
        for (const auto& [key, c] : self->connections_) asio::post(c->strand(), [p = c] { p->drain(); });
    });
}

void Listener::stop() {
    asio::post(strand_, [self = shared_from_this()] {
        self->stop_accepting();
        for (const auto& [key, c] : self->connections_) asio::post(c->strand(), [p = c] { p->end("server stopped"); });
    });
}

asio::awaitable<void> Listener::accept_loop() {
    while (acceptor_.is_open()) {
        Socket socket{Strand(workers_.next().get_executor())};
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

void Listener::admit(Socket socket, const tcp::endpoint& from) {
    if (!admission_.admit(from.address())) return refuse(std::move(socket));
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    const std::uint64_t key = next_key_++;
    const auto on_end = [self = shared_from_this(), address = from.address(), key] {
        asio::post(self->strand_, [self, address, key] { self->release(address, key); });
    };
    const auto connection =
        make_(std::move(socket), to_string(protocol::HostPort{from.address().to_string(), from.port()}), on_end);
    connections_.emplace(key, connection);
    asio::post(connection->strand(), [connection] { connection->start(); });
}

// One try to say why: a peer that is over the limit is given no buffer and no time.
void Listener::refuse(Socket socket) {
    error_code ignored;
    socket.non_blocking(true, ignored);
    if (!refusal_.empty()) socket.write_some(asio::buffer(refusal_), ignored);
    ++context_.metrics.refused;
    context_.log(LogLevel::Warning, "event=refused reason=\"too many connections\"");
}

void Listener::release(const asio::ip::address& address, std::uint64_t key) {
    connections_.erase(key);
    admission_.release(address);
}

void Listener::stop_accepting() {
    error_code ignored;
    acceptor_.close(ignored);
    retry_.cancel();
}

}  // namespace mvw::server
