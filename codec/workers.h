// A crew of threads that run one function together, with barriers between its phases.
#pragma once
#include <cstddef>
#include <functional>
#if !defined(__EMSCRIPTEN__)
#include <barrier>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>
#endif

namespace mvw {

#if defined(__EMSCRIPTEN__)
/// In a browser the caller alone, in a worker of the page's.
class Workers {
 public:
    explicit Workers(unsigned) {}
    [[nodiscard]] unsigned count() const { return 1; }
    template <typename Job>
    void run(const Job& job) {
        job(0);
    }
    void sync() {}
};
#else
/// Starts `count` - 1 threads, which sleep between jobs; the caller of run() is worker 0. With one worker no thread is
/// ever started.
class Workers {
 public:
    explicit Workers(unsigned count) : count_(count < 1 ? 1 : count), barrier_(static_cast<std::ptrdiff_t>(count_)) {
        for (unsigned w = 1; w < count_; ++w) threads_.emplace_back([this, w] { serve(w); });
    }
    ~Workers() {
        {
            const std::lock_guard lock(mutex_);
            stop_ = true;
        }
        wake_.notify_all();
        for (std::thread& t : threads_) t.join();
    }
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    [[nodiscard]] unsigned count() const { return count_; }

    /// Calls job(w) on each worker w and returns when all are done.
    void run(const std::function<void(unsigned)>& job) {
        if (count_ == 1) return job(0);
        {
            const std::lock_guard lock(mutex_);
            job_ = &job;
            ++turn_;
        }
        wake_.notify_all();
        job(0);
        barrier_.arrive_and_wait();
    }
    /// Within a job: waits until all workers are here.
    void sync() {
        if (count_ > 1) barrier_.arrive_and_wait();
    }

 private:
    void serve(unsigned worker) {
        for (std::size_t seen = 0;;) {
            const std::function<void(unsigned)>* job = nullptr;
            {
                std::unique_lock lock(mutex_);
                wake_.wait(lock, [&] { return stop_ || turn_ != seen; });
                if (stop_) return;
                seen = turn_;
                job = job_;
            }
            (*job)(worker);
            barrier_.arrive_and_wait();
        }
    }

    unsigned count_;
    std::barrier<> barrier_;
    std::mutex mutex_;
    std::condition_variable wake_;
    const std::function<void(unsigned)>* job_ = nullptr;
    std::size_t turn_ = 0;
    bool stop_ = false;
    std::vector<std::thread> threads_;
};
#endif

}  // namespace mvw
