#include "server/server.h"

#include <sys/resource.h>

#include <utility>  // before Asio, which uses std::exchange without it

#include <fmt/format.h>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>

#include <algorithm>
#include <thread>
#include <vector>

#include "server/catalogue.h"
#include "server/site.h"
#include "server/store.h"
#include "server/transport/http.h"
#include "server/transport/listener.h"
#include "server/transport/peer.h"
#include "server/transport/workers.h"

namespace mvw::server {
namespace {

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

using TlsContext = std::unique_ptr<asio::ssl::context>;

// TLS 1.2 or 1.3 with the given certificate chain; null where there is none.
Result<TlsContext> make_tls(const std::string& cert, const std::string& key) {
    if (cert.empty() && key.empty()) return TlsContext();
    if (cert.empty() || key.empty())
        return Error{Errc::InvalidArgument, 0, "TLS needs a certificate and its key, and only one is given"};
    auto tls = std::make_unique<asio::ssl::context>(asio::ssl::context::tls_server);
    error_code error;
    tls->set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_sslv2 |
                         asio::ssl::context::no_sslv3 | asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1 |
                         asio::ssl::context::no_compression,
                     error);
    tls->use_certificate_chain_file(cert, error);
    if (error) return Error{Errc::Io, 0, cert + ": " + error.message()};
    tls->use_private_key_file(key, asio::ssl::context::pem, error);
    if (error) return Error{Errc::Io, 0, key + ": " + error.message()};
    SSL_CTX_set_mode(tls->native_handle(), SSL_MODE_RELEASE_BUFFERS);  // an idle peer costs no buffer
    return tls;
}

Result<std::unique_ptr<Store>> open_store(const ServerOptions& options, Metrics& metrics) {
    if (!options.origin) return Store::open_folder(options.folder, options.limits.max_open_models);
    OriginOptions origin = *options.origin;
    origin.folder = options.folder;
    origin.max_open = options.limits.max_open_models;
    return open_origin(std::move(origin), metrics);
}

CheckToken make_check(const std::optional<TokenKeys>& keys) {
    if (!keys) return {};
    return [keys = *keys](std::string_view token, std::string_view model) {
        const auto now = std::chrono::system_clock::now().time_since_epoch();
        return keys.check(token, model, std::chrono::duration_cast<std::chrono::seconds>(now).count());
    };
}

unsigned thread_count(const ServerOptions& options) {
    return options.threads != 0 ? options.threads : std::clamp(std::thread::hardware_concurrency(), 1u, 4u);
}

// What peers over a limit are told, each in its own language; under TLS they cannot be told without a handshake.
Bytes tcp_refusal() {
    return write_message(protocol::ErrorMessage{protocol::ErrorCode::TooBusy, "too many connections"});
}
Bytes http_refusal() {
    HttpReply reply = plain_reply(503, "too many connections");
    reply.fields.emplace_back("Retry-After", "1");
    const std::string text = reply.head(false) + reply.text;
    const ByteSpan bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

}  // namespace

class Server::Impl {
 public:
    Impl(ServerOptions options, std::unique_ptr<Metrics> metrics, std::unique_ptr<Store> store, TlsContext tls)
        : options_(std::move(options)),
          own_metrics_(std::move(metrics)),
          metrics_(*own_metrics_),
          store_(std::move(store)),
          tls_(std::move(tls)),
          catalogue_(*store_),
          context_{[this](std::string_view name) { return open(name); },
                   [this](std::string_view name, const std::function<void()>& then) { store_->when_known(name, then); },
                   make_check(options_.tokens),
                   options_.limits,
                   options_.log,
                   metrics_},
          site_(context_.open, context_.allow, catalogue_, metrics_, options_.page),
          admission_(context_.limits),
          workers_(thread_count(options_)),
          tcp_listener_(std::make_shared<Listener>(
              workers_, context_, admission_,
              [this](Socket socket, std::string name, std::function<void()> on_end) {
                  return make_peer(make_carrier(std::move(socket), tls_.get()), Way::Tcp, context_, std::move(name),
                                   std::move(on_end));
              },
              tls_ ? Bytes() : tcp_refusal())),
          http_listener_(std::make_shared<Listener>(
              workers_, context_, admission_,
              [this](Socket socket, std::string name, std::function<void()> on_end) {
                  return make_http(make_carrier(std::move(socket), tls_.get()), context_, site_, std::move(name),
                                   std::move(on_end));
              },
              tls_ ? Bytes() : http_refusal())),
          control_(workers_.first().get_executor()),
          drain_timer_(control_),
          scan_timer_(control_),
          signals_(control_) {}
    ~Impl() {
        try {
            stop();
            wait();
        } catch (...) {  // the workers end with what follows
        }
        tcp_listener_->forget();
        http_listener_->forget();
        store_.reset();  // its thread may call on connections, which go with what follows
    }

    Result<void> start() {
        const Result<protocol::HostPort> tcp_bound = tcp_listener_->listen(options_.tcp);
        if (!tcp_bound) return tcp_bound.error();
        tcp_ = *tcp_bound;
        const Result<protocol::HostPort> http_bound = http_listener_->listen(options_.http);
        if (!http_bound) return http_bound.error();
        http_ = *http_bound;
        if (options_.handle_signals) {
            error_code ignored;
            signals_.add(SIGINT, ignored);
            signals_.add(SIGTERM, ignored);
            wait_for_signal();
        }
        known_ = store_->list();
        models_ = known_.size();
        options_.log(LogLevel::Info, fmt::format("event=listening tcp={} http={} tls={} tokens={} folder={} models={}",
                                                 to_string(tcp_), to_string(http_), tls_ != nullptr,
                                                 options_.tokens.has_value(), log_value(options_.folder), models_));
        scan_later();
        workers_.start();
        return {};
    }

    void drain() {
        asio::post(control_, [this] {
            if (std::exchange(ending_, true)) return;
            options_.log(LogLevel::Info, fmt::format("event=draining connections={}", admission_.connections()));
            scan_timer_.cancel();
            site_.drain();
            tcp_listener_->drain();
            http_listener_->drain();
            finish_when_empty(std::chrono::steady_clock::now() + options_.limits.drain_time);
        });
    }
    void stop() {
        asio::post(control_, [this] {
            if (std::exchange(stopped_, true)) return;
            ending_ = true;
            tcp_listener_->stop();
            http_listener_->stop();
            scan_timer_.cancel();
            drain_timer_.cancel();
            error_code ignored;
            signals_.cancel(ignored);
            workers_.finish();
        });
    }
    void wait() { workers_.wait(); }

    [[nodiscard]] protocol::HostPort tcp_address() const { return tcp_; }
    [[nodiscard]] protocol::HostPort http_address() const { return http_; }
    [[nodiscard]] std::size_t connections() const { return admission_.connections(); }
    [[nodiscard]] std::size_t models() const { return models_; }

 private:
    Result<ModelPtr> open(std::string_view name) {
        Result<ModelPtr> model = store_->open(name);
        if (!model && model.error().code != Errc::Io && model.error().code != Errc::NeedMoreData) {
            ++metrics_.reload_failures;
            options_.log(LogLevel::Warning,
                         fmt::format("event=unsound model={} reason={}", log_value(std::string(name)),
                                     log_value(model.error().message)));
        }
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
        if (admission_.connections() == 0 || std::chrono::steady_clock::now() >= deadline) return stop();
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

    ServerOptions options_;
    const std::unique_ptr<Metrics> own_metrics_;
    Metrics& metrics_;
    std::unique_ptr<Store> store_;
    const TlsContext tls_;
    Catalogue catalogue_;
    PeerContext context_;
    Site site_;
    Admission admission_;
    Workers workers_;  // after what their handlers use, which go with them
    std::shared_ptr<Listener> tcp_listener_, http_listener_;
    Strand control_;  // all that follows is touched on it alone once the threads run
    Timer drain_timer_, scan_timer_;
    asio::basic_signal_set<Strand> signals_;
    bool ending_ = false, stopped_ = false;
    std::vector<StoreEntry> known_;
    std::size_t models_ = 0;
    protocol::HostPort tcp_, http_;
};

Result<std::unique_ptr<Server>> Server::start(ServerOptions options) {
    raise_descriptor_limit();
    if (!options.log) options.log = [](LogLevel, const std::string&) {};
    auto metrics = std::make_unique<Metrics>();
    Result<std::unique_ptr<Store>> store = open_store(options, *metrics);
    if (!store) return store.error();
    Result<TlsContext> tls = make_tls(options.tls_cert, options.tls_key);
    if (!tls) return tls.error();
    if (!options.page.empty() && !open_folder(options.page).ok()) return io_error(options.page);
    auto impl = std::make_unique<Impl>(std::move(options), std::move(metrics), std::move(store).value(),
                                       std::move(tls).value());
    if (Result<void> r = impl->start(); !r) return r.error();
    return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;
protocol::HostPort Server::tcp_address() const {
    return impl_->tcp_address();
}
protocol::HostPort Server::http_address() const {
    return impl_->http_address();
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
