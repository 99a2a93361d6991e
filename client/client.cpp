#include "client/client.h"

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>

#include <condition_variable>
#include <mutex>
#include <random>
#include <thread>

#include "client/transport/tcp.h"

namespace mvw::client {

namespace asio = boost::asio;

class Stream::Impl {
 public:
    Impl(Url url, StreamOptions options, Callbacks callbacks)
        : callbacks_(std::move(callbacks)),
          feed_(options.limits, options.keep_chunks,
                [this](const Refinement& r, const Decoder& d) {
                    if (callbacks_.refined) callbacks_.refined(r, d);
                }),
          session_(std::move(url.model), std::move(options.token), std::move(options.wants), options.retry,
                   options.limits, std::random_device{}()),
          work_(asio::make_work_guard(io_)),
          transport_(io_, url.address, session_, [this](Action&& action) { tell(std::move(action)); }) {
        asio::post(io_, [this] { transport_.perform(session_.start(Clock::now())); });
        thread_ = std::thread([this] { io_.run(); });
    }
    ~Impl() {
        feed_.stop();  // first: the network thread may wait for room in it
        asio::post(io_, [this] {
            transport_.stop();
            work_.reset();
        });
        thread_.join();
    }

    void want(Wants wants) {
        forget_outcome();  // for a wait() that follows
        asio::post(io_, [this, w = std::move(wants)]() mutable {
            forget_outcome();  // of the wants before, which may have come meanwhile
            transport_.perform(session_.want(std::move(w), Clock::now()));
        });
    }
    void cancel() {
        asio::post(io_, [this] { transport_.perform(session_.cancel(Clock::now())); });
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
    void tell(Action&& action) {
        if (auto* opened = std::get_if<Opened>(&action)) {
            if (callbacks_.opened) callbacks_.opened(*opened);
            count([&](Summary& s) { s.model_payload_bytes = opened->payload_bytes; });
            feed_.push(std::move(*opened));
        } else if (auto* chunk = std::get_if<Received>(&action)) {
            feed_.push(std::move(*chunk));
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
    Session session_;
    asio::io_context io_;
    asio::executor_work_guard<asio::io_context::executor_type> work_;
    TcpTransport transport_;
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
