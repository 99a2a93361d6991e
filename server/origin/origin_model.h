// One model of an HTTP store: header and index in memory, the rest fetched in pieces into a cached file when it is
// asked for. Inside origin/ only.
#pragma once
#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>

#include <atomic>
#include <deque>
#include <memory>
#include <string>

#include "server/metrics.h"
#include "server/model_source.h"
#include "server/origin/cached_file.h"
#include "server/origin/http_client.h"

namespace mvw::server {

/// What all models of a store share. Outlives the last fetch().
struct OriginLink {
    boost::asio::io_context& io;  // run by one thread
    HttpClient& client;
    Metrics& metrics;

    /// One request, counted.
    boost::asio::awaitable<Result<RangeAnswer>> get(StoreUrl url, std::uint64_t first, std::uint64_t last,
                                                    std::string unless) const;
};

/// Fetches are one after the other, so that what several peers want at once is asked for once.
class OriginModel final : public ModelSource, public std::enable_shared_from_this<OriginModel> {
 public:
    OriginModel(const OriginLink& link, StoreUrl url, std::string validator, Toc toc, Bytes header,
                std::uint64_t file_bytes, std::shared_ptr<CachedFile> file);

    Result<void> read(std::uint64_t offset, std::span<std::byte> out) const override {
        return file_->read(offset, out);
    }
    [[nodiscard]] int descriptor() const override { return file_->descriptor(); }
    [[nodiscard]] bool ready(std::uint64_t offset, std::uint64_t length) const override {
        return file_->has(offset, length);
    }
    void fetch(std::uint64_t offset, std::uint64_t length, const Fetched& done) const override;
    [[nodiscard]] bool intact() const override { return !changed_; }

    /// True once the store has refused a piece under this URL: another one may be needed (signatures expire).
    [[nodiscard]] bool refused() const { return refused_; }
    [[nodiscard]] const std::string& validator() const { return validator_; }

 private:
    struct Job {
        std::uint64_t offset, length;
        Fetched done;
    };
    boost::asio::awaitable<void> work() const;
    boost::asio::awaitable<Result<void>> bring(std::uint64_t offset, std::uint64_t length) const;

    const OriginLink& link_;
    const StoreUrl url_;
    const std::string validator_;
    const std::shared_ptr<CachedFile> file_;
    mutable std::atomic<bool> changed_ = false, refused_ = false;
    mutable std::deque<Job> jobs_;  // touched on the link's thread alone, like the next
    mutable bool working_ = false;
};

}  // namespace mvw::server
