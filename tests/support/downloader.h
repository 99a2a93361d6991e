// A client without a decoder, for tests of servers.
#pragma once
#include <gtest/gtest.h>

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/transport/stream.h"
#include "tests/support/stream_models.h"

namespace mvw::test {

/// Speaks the native protocol over TCP or WebSocket: counts chunks, and waits where it is told to.
class Downloader {
 public:
    Downloader(const protocol::HostPort& address, const std::string& model, client::Wants wants = {},
               std::size_t pause_at = SIZE_MAX)
        : Downloader(client::Url{client::Scheme::Tcp, address, model, false, {}}, std::move(wants), pause_at) {}
    /// `tls` outlives it; used where the URL says so.
    explicit Downloader(const client::Url& url, client::Wants wants = {}, std::size_t pause_at = SIZE_MAX,
                        boost::asio::ssl::context* tls = nullptr)
        : pause_at_(pause_at),
          session_(url.model, "", std::move(wants)),
          transport_(io_, url, tls, session_, [this](client::Action&& a) { take(std::move(a)); }) {
        boost::asio::post(io_, [this] { transport_.perform(session_.start(client::Clock::now())); });
        thread_ = std::thread([this] { io_.run(); });
    }
    ~Downloader() {
        go_on();
        boost::asio::post(io_, [this] { transport_.stop(); });
        thread_.join();
    }
    bool wait_for_pause() {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, std::chrono::seconds(20), [&] { return received.size() >= pause_at_; });
    }
    void go_on() {
        const std::lock_guard lock(mutex_);
        released_ = true;
        changed_.notify_all();
    }
    bool wait() {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, std::chrono::seconds(60), [&] { return satisfied || failed; });
    }
    // What came is the whole of that file, each chunk once.
    void expect_all_of(const Bytes& file) {
        const auto model = MemoryModel::make(file);
        ASSERT_EQ(received.size(), model->toc().chunks.size());
        std::vector<bool> seen(received.size());
        for (const client::Received& r : received) {
            ASSERT_LT(r.index, seen.size());
            EXPECT_FALSE(seen[r.index]) << "chunk " << r.index << " came twice";
            seen[r.index] = true;
            Bytes expected(model->toc().chunks[r.index].length);
            ASSERT_TRUE(model->read(model->toc().chunks[r.index].offset, expected).ok());
            EXPECT_EQ(r.payload, expected);
        }
    }

    std::vector<client::Received> received;
    std::optional<protocol::EndReason> satisfied;
    std::optional<Error> failed;
    int resumed = 0, restarted = 0;

 private:
    void take(client::Action&& action) {
        std::unique_lock lock(mutex_);
        if (auto* chunk = std::get_if<client::Received>(&action)) {
            received.push_back(std::move(*chunk));
            changed_.notify_all();
            if (received.size() == pause_at_) changed_.wait(lock, [&] { return released_; });
        } else if (auto* s = std::get_if<client::Satisfied>(&action)) {
            satisfied = s->reason;
        } else if (auto* f = std::get_if<client::Failed>(&action)) {
            failed = f->why;
        } else if (std::holds_alternative<client::Resumed>(action)) {
            ++resumed;
        } else if (std::holds_alternative<client::Restarted>(action)) {
            ++restarted;
            received.clear();
            pause_at_ = SIZE_MAX;
        }
        changed_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::size_t pause_at_;
    bool released_ = false;
    boost::asio::io_context io_;
    client::Session session_;
    client::StreamTransport transport_;
    std::thread thread_;
};

}  // namespace mvw::test
