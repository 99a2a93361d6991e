#include "server/server.h"

#include <sys/resource.h>

#include <utility>  // before Asio, which uses std::exchange without it

#include <fmt/format.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>

#include <algorithm>
#include <csignal>
#include <thread>
#include <vector>

#include "server/store.h"
#include "server/transport/tcp.h"

namespace mvw::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr std::chrono::seconds kScanEvery{5};

// Thousands of peers need thousands of descriptors: ask for all that the system allows.
void raise_descriptor_limit() {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
}

// Tells what came, went and changed between two lists, both by name.
void log_changes(const std::vector<StoreEntry>& before, const std::vector<StoreEntry>& after, const Log& log) {
    const auto tell = [&](const char* event, const StoreEntry& e) {
        log(LogLevel::Info, fmt::format("event={} model={} bytes={}", event, log_value(e.name), e.stamp.bytes));
    };
    auto a = before.begin();
    auto b = after.begin();
    while (a != before.end() || b != after.end()) {
        if (b == after.end() || (a != before.end() && a->name < b->name)) {
            tell("removed", *a++);
        } else if (a == before.end() || b->name < a->name) {
            tell("added", *b++);
        } else {
            if (a->stamp != b->stamp) tell("replaced", *b);
            ++a, ++b;
        }
    }
}

}  // namespace

class Server::Impl {
 public:
    Impl(ServerOptions options, std::unique_ptr<Store> store)
        : options_(std::move(options)),
          store_(std::move(store)),
          context_{[this](std::string_view name) { return open(name); }, options_.limits, options_.log},
          listener_(io_, context_),
          control_(io_.get_executor()),
          drain_timer_(control_),
          scan_timer_(control_),
          signals_(control_) {}
    ~Impl() {
        stop();
        wait();
    }

    Result<void> start() {
        Result<protocol::HostPort> bound = listener_.listen(options_.tcp);
        if (!bound) return bound.error();
        tcp_ = *bound;
        if (options_.handle_signals) {
            error_code ignored;
            signals_.add(SIGINT, ignored);
            signals_.add(SIGTERM, ignored);
            wait_for_signal();
        }
        known_ = store_->list();
        models_ = known_.size();
        options_.log(LogLevel::Info, fmt::format("event=listening transport=tcp address={} folder={} models={}",
                                                 to_string(tcp_), log_value(options_.folder), models_));
        scan_later();
        const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
        const unsigned threads = options_.threads != 0 ? options_.threads : std::min(4u, cores);
        for (unsigned i = 0; i < threads; ++i) threads_.emplace_back([this] { io_.run(); });
        return {};
    }

    void drain() {
        asio::post(control_, [this] {
            if (std::exchange(ending_, true)) return;
            options_.log(LogLevel::Info, fmt::format("event=draining connections={}", listener_.connections()));
            scan_timer_.cancel();
            listener_.drain();
            finish_when_empty(std::chrono::steady_clock::now() + options_.limits.drain_time);
        });
    }
    void stop() {
        asio::post(control_, [this] {
            if (std::exchange(stopped_, true)) return;
            ending_ = true;
            listener_.stop();
            scan_timer_.cancel();
            drain_timer_.cancel();
            error_code ignored;
            signals_.cancel(ignored);
        });
    }
    void wait() {
        for (std::thread& t : threads_)
            if (t.joinable()) t.join();
    }

    [[nodiscard]] protocol::HostPort tcp_address() const { return tcp_; }
    [[nodiscard]] std::size_t connections() const { return listener_.connections(); }
    [[nodiscard]] std::size_t models() const { return models_; }

 private:
    Result<ModelPtr> open(std::string_view name) {
        Result<ModelPtr> model = store_->open(name);
        if (!model && model.error().code != Errc::Io)
            options_.log(LogLevel::Warning,
                         fmt::format("event=unsound model={} reason={}", log_value(std::string(name)),
                                     log_value(model.error().message)));
        return model;
    }

    void wait_for_signal() {
        signals_.async_wait([this](const error_code& error, int) {
            if (error) return;
            ending_ ? stop() : drain();
            wait_for_signal();
        });
    }

    // Looks often rather than being told: the last peer's end is no news worth a channel of its own.
    void finish_when_empty(std::chrono::steady_clock::time_point deadline) {
        if (listener_.connections() == 0 || std::chrono::steady_clock::now() >= deadline) return stop();
        drain_timer_.expires_after(std::chrono::milliseconds(20));
        drain_timer_.async_wait([this, deadline](const error_code& error) {
            if (!error) finish_when_empty(deadline);
        });
    }

    void scan_later() {
        scan_timer_.expires_after(kScanEvery);
        scan_timer_.async_wait([this](const error_code& error) {
            if (error || ending_) return;
            std::vector<StoreEntry> now = store_->list();
            log_changes(known_, now, options_.log);
            known_ = std::move(now);
            scan_later();
        });
    }

    using Strand = asio::strand<asio::io_context::executor_type>;
    using Timer =
        asio::basic_waitable_timer<std::chrono::steady_clock, asio::wait_traits<std::chrono::steady_clock>, Strand>;
    ServerOptions options_;
    std::unique_ptr<Store> store_;
    asio::io_context io_;
    PeerContext context_;
    TcpListener listener_;
    Strand control_;  // all that follows is touched on it alone once the threads run
    Timer drain_timer_, scan_timer_;
    asio::basic_signal_set<Strand> signals_;
    bool ending_ = false, stopped_ = false;
    std::vector<StoreEntry> known_;
    std::size_t models_ = 0;
    protocol::HostPort tcp_;
    std::vector<std::thread> threads_;
};

Result<std::unique_ptr<Server>> Server::start(ServerOptions options) {
    raise_descriptor_limit();
    if (!options.log) options.log = [](LogLevel, const std::string&) {};
    Result<std::unique_ptr<Store>> store = Store::open_folder(options.folder, options.limits.max_open_models);
    if (!store) return store.error();
    auto impl = std::make_unique<Impl>(std::move(options), std::move(store).value());
    if (Result<void> r = impl->start(); !r) return r.error();
    return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;
protocol::HostPort Server::tcp_address() const {
    return impl_->tcp_address();
}
std::size_t Server::connections() const {
    return impl_->connections();
}
std::size_t Server::models() const {
    return impl_->models();
}
void Server::drain() {
    impl_->drain();
}
void Server::stop() {
    impl_->stop();
}
void Server::wait() {
    impl_->wait();
}

}  // namespace mvw::server
