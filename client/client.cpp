#include "client/client.h"

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>

#include <condition_variable>
#include <mutex>
#include <random>
#include <thread>

#include "client/cache.h"
#include "client/transport/link.h"
#include "client/transport/wire.h"

namespace mvw::client {

class Stream::Impl {
 public:
    Impl(Url url, StreamOptions options, Callbacks callbacks)
        : callbacks_(std::move(callbacks)),
          feed_(options.limits, options.keep_chunks,
                [this](const Refinement& r, const Decoder& d) {
                    if (callbacks_.refined) callbacks_.refined(r, d);
                }),
          work_(asio::make_work_guard(io_)) {
        Result<std::unique_ptr<asio::ssl::context>> tls =
            url.tls ? make_client_tls(options.ca_file) : std::unique_ptr<asio::ssl::context>();
        if (!tls) {
            end(tls.error());
            return;
        }
        tls_ = std::move(tls).value();
        LinkOptions link{std::move(options.wants), options.retry, options.limits, std::move(options.token),
                         std::random_device{}()};
        link_ = make_link(io_, tls_.get(), url, std::move(link), [this](Notice&& notice) { tell(std::move(notice)); });
        if (!options.cache_folder.empty()) open_cache(url, options);
        asio::post(io_, [this] { start(); });
        thread_ = std::thread([this] { io_.run(); });
    }
    ~Impl() {
        feed_.stop();  // first: the network thread may wait for room in it
        if (!thread_.joinable()) return;
        asio::post(io_, [this] {
            link_->stop();
            work_.reset();
        });
        thread_.join();
    }

    void want(Wants wants) {
        forget_outcome();  // for a wait() that follows
        asio::post(io_, [this, w = std::move(wants)]() mutable {
            forget_outcome();  // of the wants before, which may have come meanwhile
            link_->want(std::move(w));
        });
    }
    void cancel() {
        asio::post(io_, [this] { link_->cancel(); });
    }
    Result<Summary> wait() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return outcome_.has_value(); });
        const Result<protocol::EndReason> outcome = *outcome_;
        lock.unlock();
        feed_.wait_idle();
        if (!outcome) return outcome.error();
        if (feed_.error()) return *feed_.error();
        lock.lock();
        Summary summary = summary_;
        summary.reason = *outcome;
        summary.seconds = std::chrono::duration<double>(Clock::now() - begun_).count();
        summary.first_mesh_seconds = feed_.first_mesh_seconds();
        return summary;
    }
    [[nodiscard]] const Feed& feed() const { return feed_; }

 private:
    void open_cache(const Url& url, const StreamOptions& options) {
        const std::string key = (url.tls ? "s " : "") + to_string(url.address) + " " +
                                (url.scheme == Scheme::Http ? url.target : url.model);
        cache_.emplace(ChunkCache::Options{options.cache_folder, options.cache_bytes}, key);
        stored_ = cache_->load(options.limits);
    }

    void start() {
        if (stored_) {
            count([&](Summary& s) {
                for (const Received& chunk : stored_->chunks) s.cached_bytes += chunk.payload.size();
            });
            link_->restore(std::move(*stored_));
        }
        link_->start();
    }

    void tell(Notice&& action) {
        if (cache_) keep(action);
        if (auto* opened = std::get_if<Opened>(&action)) {
            if (callbacks_.opened) callbacks_.opened(*opened);
            count([&](Summary& s) { s.model_payload_bytes = opened->payload_bytes; });
            feed_.push(std::move(*opened));
        } else if (auto* chunk = std::get_if<Received>(&action)) {
            feed_.push(std::move(*chunk));
        } else if (auto* indexed = std::get_if<Indexed>(&action)) {
            feed_.push(std::move(*indexed));
        } else if (const auto* satisfied = std::get_if<Satisfied>(&action)) {
            end(satisfied->reason);
        } else if (const auto* broken = std::get_if<Broken>(&action)) {
            if (callbacks_.broken) callbacks_.broken(*broken);
        } else if (std::holds_alternative<Resumed>(action)) {
            count([](Summary& s) { ++s.resumed; });
            if (callbacks_.resumed) callbacks_.resumed();
        } else if (const auto* restarted = std::get_if<Restarted>(&action)) {
            count([](Summary& s) { ++s.restarted; });
            feed_.push(*restarted);
            if (callbacks_.restarted) callbacks_.restarted();
        } else if (const auto* failed = std::get_if<Failed>(&action)) {
            end(failed->why);
        }
    }

    void keep(const Notice& notice) {
        if (const auto* opened = std::get_if<Opened>(&notice))
            cache_->begin(*opened, link_->etag());
        else if (const auto* chunk = std::get_if<Received>(&notice))
            cache_->put(*chunk);
        else if (std::holds_alternative<Restarted>(notice))
            count([](Summary& s) { s.cached_bytes = 0; });
    }

    // A failure stays: nothing comes after it.
    void forget_outcome() {
        const std::lock_guard lock(mutex_);
        if (outcome_ && outcome_->ok()) outcome_.reset();
    }

    template <typename Change>
    void count(Change change) {
        const std::lock_guard lock(mutex_);
        change(summary_);
    }

    void end(Result<protocol::EndReason> outcome) {
        const std::lock_guard lock(mutex_);
        outcome_ = std::move(outcome);
        changed_.notify_all();
    }

    const Clock::time_point begun_ = Clock::now();
    const Callbacks callbacks_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Result<protocol::EndReason>> outcome_;
    Summary summary_;
    Feed feed_;
    std::unique_ptr<asio::ssl::context> tls_;
    std::optional<ChunkCache> cache_;
    std::optional<Stored> stored_;  // until start()
    asio::io_context io_;
    asio::executor_work_guard<asio::io_context::executor_type> work_;
    std::unique_ptr<Link> link_;
    std::thread thread_;
};

Stream::Stream(Url url, StreamOptions options, Callbacks callbacks)
    : impl_(std::make_unique<Impl>(std::move(url), std::move(options), std::move(callbacks))) {}
Stream::~Stream() = default;
void Stream::want(Wants wants) {
    impl_->want(std::move(wants));
}
void Stream::cancel() {
    impl_->cancel();
}
Result<Summary> Stream::wait() {
    return impl_->wait();
}
const Feed& Stream::feed() const {
    return impl_->feed();
}

}  // namespace mvw::client
