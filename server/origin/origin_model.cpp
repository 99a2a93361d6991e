#include "server/origin/origin_model.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>

#include <algorithm>

namespace mvw::server {
namespace {

namespace asio = boost::asio;

constexpr std::uint64_t kPieceBytes = 1u << 20;  // of one request: what is asked for and, in file order, what follows

}  // namespace

asio::awaitable<Result<RangeAnswer>> OriginLink::get(StoreUrl url, std::uint64_t first, std::uint64_t last,
                                                     std::string unless) const {
    ++metrics.origin_requests;
    Result<RangeAnswer> answer = co_await client.get(std::move(url), first, last, std::move(unless));
    if (answer.ok())
        metrics.origin_bytes += answer->body.size();
    else
        ++metrics.origin_failures;
    co_return answer;
}

OriginModel::OriginModel(const OriginLink& link, StoreUrl url, std::string validator, Toc toc, Bytes header,
                         std::uint64_t file_bytes, std::shared_ptr<CachedFile> file)
    : ModelSource(std::move(toc), std::move(header), file_bytes),
      link_(link),
      url_(std::move(url)),
      validator_(std::move(validator)),
      file_(std::move(file)) {}

void OriginModel::fetch(std::uint64_t offset, std::uint64_t length, const Fetched& done) const {
    asio::post(link_.io, [self = shared_from_this(), job = Job{offset, length, done}]() mutable {
        self->jobs_.push_back(std::move(job));
        if (std::exchange(self->working_, true)) return;
        asio::co_spawn(
            self->link_.io, [self] { return self->work(); }, asio::detached);
    });
}

asio::awaitable<void> OriginModel::work() const {
    while (!jobs_.empty()) {
        const Job job = std::move(jobs_.front());
        jobs_.pop_front();
        const Result<void> brought = co_await bring(job.offset, job.length);
        job.done(brought);
    }
    working_ = false;
}

asio::awaitable<Result<void>> OriginModel::bring(std::uint64_t offset, std::uint64_t length) const {
    constexpr std::uint64_t kBlock = CachedFile::kBlockBytes;
    const std::string always;  // named: g++ 12 mixes up temporaries that live across a co_await
    if (offset > file_bytes() || length > file_bytes() - offset)
        co_return Error{Errc::Io, offset, "beyond the end of the model"};
    for (std::uint64_t first = offset / kBlock; first * kBlock < offset + length; ++first) {
        if (file_->has_block(first)) continue;
        std::uint64_t end = first + 1;
        while (end < file_->blocks() && !file_->has_block(end) && (end - first) * kBlock < kPieceBytes) ++end;
        const Result<RangeAnswer> answer =
            co_await link_.get(url_, first * kBlock, std::min(end * kBlock, file_bytes()) - 1, always);
        if (!answer) co_return answer.error();
        if (answer->status != 206) {
            refused_ = true;
            co_return Error{Errc::Io, offset, "the store answers " + std::to_string(answer->status)};
        }
        if (answer->file_bytes != file_bytes() || answer->validator != validator_) {
            changed_ = true;
            co_return Error{Errc::Io, offset, "the store has another model under this name now"};
        }
        if (Result<void> kept = file_->put(first * kBlock, answer->body); !kept) co_return kept;
        if (!file_->has_block(first)) co_return Error{Errc::Io, offset, "the store's answer is too short"};
    }
    co_return Result<void>();
}

}  // namespace mvw::server
