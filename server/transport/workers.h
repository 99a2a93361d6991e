// The threads of a server, each with a queue of its own. A connection stays with the thread it was given, so that none
// waits for another's lock or wakes it for its own work. Inside the server only.
#pragma once
#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

namespace mvw::server {

class Workers {
 public:
    /// `count` is at least 1.
    explicit Workers(unsigned count);
    ~Workers();  // after wait(), or before start()
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    /// The queue of the first thread, for what there is one of.
    [[nodiscard]] boost::asio::io_context& first() { return workers_.front()->io; }
    /// A queue for another connection, each in turn. From any thread.
    [[nodiscard]] boost::asio::io_context& next() { return workers_[turn_++ % workers_.size()]->io; }

    void start();
    /// Threads end once they have nothing left to do. From any thread, once.
    void finish();
    void wait();

 private:
    struct Worker {
        boost::asio::io_context io{1};  // one thread runs it; others may post
        boost::asio::executor_work_guard<boost::asio::io_context::executor_type> more{io.get_executor()};
        std::thread thread;
    };
    std::vector<std::unique_ptr<Worker>> workers_;
    std::atomic<std::size_t> turn_ = 0;
};

}  // namespace mvw::server
