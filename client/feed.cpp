#include "client/feed.h"

#include <utility>
#include <vector>

#include "codec/container/enc_file.h"

namespace mvw::client {
namespace {

constexpr std::size_t kMaxQueuedBytes = 16u << 20;

// Payload bytes, the bulk of what waits.
template <typename Item>
std::size_t weight(const Item& item) {
    const auto* chunk = std::get_if<Received>(&item);
    return chunk == nullptr ? 0 : chunk->payload.size();
}

}  // namespace

Feed::Feed(const Limits& limits, bool keep_chunks, OnRefined on_refined)
    : limits_(limits), keep_chunks_(keep_chunks), on_refined_(std::move(on_refined)), decoder_(limits) {
    thread_ = std::thread([this] { run(); });
}

Feed::~Feed() {
    stop();
    thread_.join();
}

void Feed::push(Opened opened) {
    push_item(std::move(opened));
}
void Feed::push(Received chunk) {
    push_item(std::move(chunk));
}
void Feed::push(Indexed indexed) {
    push_item(std::move(indexed));
}
void Feed::push(Restarted restarted) {
    push_item(restarted);
}

void Feed::push_item(Item item) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stopped_ || queued_bytes_ < kMaxQueuedBytes; });
    if (stopped_) return;
    queued_bytes_ += weight(item);
    queue_.push_back(std::move(item));
    changed_.notify_all();
}

void Feed::wait_idle() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stopped_ || (queue_.empty() && !busy_); });
}

void Feed::stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
}

void Feed::run() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [&] { return stopped_ || !queue_.empty(); });
        if (stopped_) return;
        Item item = std::move(queue_.front());
        queue_.pop_front();
        queued_bytes_ -= weight(item);
        busy_ = true;
        changed_.notify_all();
        lock.unlock();
        std::visit([this](auto& i) { take(i); }, item);
        lock.lock();
        busy_ = false;
        changed_.notify_all();
    }
}

void Feed::take(Opened& opened) {
    const Result<void> fed = decoder_->feed_header(opened.header);
    if (!fed && !error_) error_ = fed.error();
    header_ = std::move(opened.header);
}

void Feed::take(Received& chunk) {
    const std::uint64_t before = decoder_->revision();
    const double begun = seconds();
    const Result<void> fed = decoder_->feed_chunk(chunk.id, chunk.payload, chunk.crc32c);
    decode_seconds_ += seconds() - begun;
    if (!fed && !error_) error_ = fed.error();
    if (chunk.error == kUnknownError) chunk.error = decoder_->state().error;
    ahead_[chunk.index] = chunk.error;
    for (auto next = ahead_.begin(); next != ahead_.end() && next->first == row_; next = ahead_.erase(next), ++row_)
        row_error_ = next->second;
    const bool refined = decoder_->revision() != before;
    if (refined && !first_mesh_) first_mesh_ = seconds();
    const ChunkId id = chunk.id;
    if (keep_chunks_) kept_.insert_or_assign(chunk.index, std::move(chunk));
    if (!refined) return;
    std::size_t waiting = 0;
    {
        const std::lock_guard lock(mutex_);
        waiting = queue_.size();
    }
    on_refined_({id, state(), seconds(), decode_seconds_, waiting, this}, *decoder_);
}

void Feed::take(Indexed& indexed) {
    const auto error_of = [&](std::uint32_t index, float stated) {
        return index < indexed.errors.size() ? indexed.errors[index] : stated;
    };
    if (row_ > 0) row_error_ = error_of(row_ - 1, row_error_);
    for (auto& [index, error] : ahead_) error = error_of(index, error);
    for (auto& [index, chunk] : kept_) chunk.error = error_of(index, chunk.error);
}

void Feed::take(Restarted&) {
    decoder_.emplace(limits_);
    first_mesh_.reset();
    error_.reset();
    header_.clear();
    row_ = 0;
    row_error_ = 1;
    ahead_.clear();
    kept_.clear();
}

DecodeState Feed::state() const {
    DecodeState state = decoder_->state();
    state.error = row_error_;
    return state;
}

double Feed::seconds() const {
    return std::chrono::duration<double>(Clock::now() - begun_).count();
}

Decoder Feed::decoder_of(unsigned layer, double bytes) const {
    Decoder decoder(limits_);
    (void)decoder.feed_header(header_).ok();  // what is unsound was told when it came
    auto left = bytes - static_cast<double>(header_.size());
    for (const auto& [index, chunk] : kept_) {
        left -= static_cast<double>(chunk.payload.size());
        if (left < 0) break;
        if (decoder.header() != nullptr && in_layers(*decoder.header(), chunk.id, layer))
            (void)decoder.feed_chunk(chunk.id, chunk.payload, chunk.crc32c).ok();
    }
    return decoder;
}

Result<Bytes> Feed::file() const {
    Result<FileHeader> header = read_header(header_, limits_);
    if (!header) return header.error();
    std::vector<ChunkToWrite> chunks;
    chunks.reserve(kept_.size());
    for (const auto& [index, chunk] : kept_) chunks.push_back({chunk.id, chunk.payload, chunk.error});
    return write_file(std::move(header).value(), chunks, limits_);
}

}  // namespace mvw::client
