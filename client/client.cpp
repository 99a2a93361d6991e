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
    Impl(const Url& url, StreamOptions options, Callbacks callbacks)
        : callbacks_(std::move(callbacks)),
          feed_(options.limits, options.keep_chunks,
                [this](const Refinement& r, const Decoder& d) {
                    note_places(d);
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
        wants_ = options.wants;
        view_ = options.view;
        if (view_ && view_->pixel_error > 0) options.wants.max_level = 0;
        LinkOptions link{std::move(options.wants), options.retry,          options.limits,
                         std::move(options.token), std::random_device{}(), options.pace};
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
        const std::lock_guard lock(look_mutex_);
        wants_ = std::move(wants);
        pass_on_wants();
    }
    void look(const View& view) {
        const std::lock_guard lock(look_mutex_);
        if (view_ == view) return;
        view_ = view;
        if (!places_.empty()) pass_on_wants();
    }
    void cancel() {
        const std::lock_guard lock(look_mutex_);
        view_.reset();  // no base that still comes makes it want more
        asio::post(io_, [this] { link_->cancel(); });
    }
    Result<Summary> wait() {
        std::unique_lock lock(mutex_);
        std::optional<Result<protocol::EndReason>> outcome;
        do {
            changed_.wait(lock, [&] { return outcome_.has_value(); });
            outcome = outcome_;
            lock.unlock();
            feed_.wait_idle();  // what is decoded last may show that a view wants more
            lock.lock();
        } while (!outcome_);
        lock.unlock();
        if (!outcome->ok()) return outcome->error();
        if (feed_.error()) return *feed_.error();
        lock.lock();
        Summary summary = summary_;
        summary.reason = **outcome;
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

    // On the decoding thread: where the tiles are, once another part's base has come.
    void note_places(const Decoder& decoder) {
        const std::lock_guard lock(look_mutex_);
        if (!view_) return;
        std::size_t vertices = 0;
        for (std::size_t part = 0; part < decoder.header()->parts.size(); ++part)
            if (const BaseMesh* base = decoder.base(part)) vertices += base->vertex_count();
        if (vertices == placed_vertices_) return;
        placed_vertices_ = vertices;
        places_ = place_tiles(decoder);
        pass_on_wants();
    }

    // Under look_mutex_, so that the last wants are those that are asked for.
    void pass_on_wants() {
        Wants wants = wants_;
        if (view_ && wants.tiles.empty()) wants.tiles = choose_tiles(places_, *view_);
        if (view_ && !wants.tiles.empty() && !view_->outside) wants.other_priority = 0;
        forget_outcome();  // for a wait() that follows
        asio::post(io_, [this, w = std::move(wants)]() mutable {
            {
                const std::lock_guard lock(mutex_);
                --unpassed_wants_;
            }
            link_->want(std::move(w));
        });
    }

    // A failure stays: nothing comes after it.
    void forget_outcome() {
        const std::lock_guard lock(mutex_);
        ++unpassed_wants_;
        if (outcome_ && outcome_->ok()) outcome_.reset();
    }

    template <typename Change>
    void count(Change change) {
        const std::lock_guard lock(mutex_);
        change(summary_);
    }

    void end(Result<protocol::EndReason> outcome) {
        const std::lock_guard lock(mutex_);
        if (outcome.ok() && unpassed_wants_ > 0) return;  // of wants that others have taken the place of
        outcome_ = std::move(outcome);
        changed_.notify_all();
    }

    const Clock::time_point begun_ = Clock::now();
    const Callbacks callbacks_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Result<protocol::EndReason>> outcome_;
    unsigned unpassed_wants_ = 0;  // on their way to the network thread
    Summary summary_;
    std::mutex look_mutex_;  // of the next four; taken before mutex_
    Wants wants_;
    std::optional<View> view_;
    std::vector<TilePlace> places_;
    std::size_t placed_vertices_ = 0;
    Feed feed_;
    std::unique_ptr<asio::ssl::context> tls_;
    std::optional<ChunkCache> cache_;
    std::optional<Stored> stored_;  // until start()
    asio::io_context io_;
    asio::executor_work_guard<asio::io_context::executor_type> work_;
    std::unique_ptr<Link> link_;
    std::thread thread_;
};

Stream::Stream(const Url& url, StreamOptions options, Callbacks callbacks)
    : impl_(std::make_unique<Impl>(url, std::move(options), std::move(callbacks))) {}
Stream::~Stream() = default;
void Stream::want(Wants wants) {
    impl_->want(std::move(wants));
}
void Stream::look(const View& view) {
    impl_->look(view);
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
