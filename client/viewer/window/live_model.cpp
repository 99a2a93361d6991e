#include "client/viewer/window/live_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "codec/container/toc.h"
#include "codec/mesh/io/files.h"

namespace mvw::client {
namespace {

// Of a file's chunks as far as `bytes` go, no layer above `layer`; of one without a sound index, its beginning.
Decoder decoder_of_file(ByteSpan file, const Limits& limits, unsigned layer, double bytes) {
    Decoder decoder(limits);
    const ByteSpan front = file.first(static_cast<std::size_t>(std::min(bytes, static_cast<double>(file.size()))));
    const Result<FileHeader> header = read_header(file, limits);
    const Result<Toc> toc = header.ok() && header->file_bytes() <= file.size()
                                ? read_toc(*header, file.subspan(header->index_offset), file.size(), limits)
                                : Result<Toc>(Error{});
    if (!toc.ok()) {
        (void)decoder.feed(front).ok();
        decoder.finish();
        return decoder;
    }
    (void)decoder.feed_header(file.first(header->header_bytes)).ok();
    for (const ChunkEntry& chunk : toc->chunks) {
        if (chunk.offset + chunk.length > front.size()) break;
        if (in_layers(*header, chunk.id, layer))
            (void)decoder.feed_chunk(chunk.id, file.subspan(chunk.offset, chunk.length), chunk.crc32c).ok();
    }
    return decoder;
}

}  // namespace

LiveModel::LiveModel(std::string place, StreamOptions options)
    : place_(std::move(place)), options_(std::move(options)), thread_([this] { run(); }) {}

bool LiveChoice::is_of_all(const FileHeader& header) const {
    return layer + 1 >= header.layers && bytes >= static_cast<double>(header.file_bytes());
}

LiveModel::~LiveModel() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        if (stream_ != nullptr) stream_->cancel();
        changed_.notify_all();
    }
    thread_.join();
}

std::unique_ptr<LiveFrame> LiveModel::take() {
    const std::lock_guard lock(mutex_);
    return std::move(frame_);
}

void LiveModel::show(const LiveChoice& choice) {
    const std::lock_guard lock(mutex_);
    shown_ = choice;
    ++asked_;
    changed_.notify_all();
}

void LiveModel::look(const View& view) {
    const std::lock_guard lock(mutex_);
    view_ = view;
    if (stream_ != nullptr && !stopping_) stream_->look(view);
}

std::string LiveModel::message() const {
    const std::lock_guard lock(mutex_);
    return message_;
}

bool LiveModel::ended() const {
    const std::lock_guard lock(mutex_);
    return ended_;
}

bool LiveModel::settled() const {
    const std::lock_guard lock(mutex_);
    return ended_ && answered_ == asked_ && !frame_;
}

void LiveModel::say(std::string message) {
    const std::lock_guard lock(mutex_);
    message_ = std::move(message);
}

void LiveModel::note(const DecodeState& state) {
    const std::lock_guard lock(mutex_);
    const auto bytes = static_cast<float>(state.bytes);
    if (!curve_.empty() && bytes < curve_.back()[0]) curve_.clear();  // the model was begun anew
    if (state.error < 1 && (curve_.empty() || bytes > curve_.back()[0])) curve_.push_back({bytes, state.error});
}

void LiveModel::run() {
    if (place_.find("://") == std::string::npos) return read_file();
    const Result<Url> url = parse_url(place_);
    if (url.ok()) return stream(*url);
    say(url.error().message);
    const std::lock_guard lock(mutex_);
    ended_ = true;
    answered_ = asked_;
}

void LiveModel::stream(const Url& url) {
    Callbacks callbacks;
    callbacks.refined = [this](const Refinement& r, const Decoder& decoder) {
        note(r.state);
        decode_seconds_ = r.decode_seconds;
        const auto less = [&](unsigned layer, double bytes) { return r.feed->decoder_of(layer, bytes); };
        if (r.waiting == 0) draw(decoder, r.state, less);
    };
    callbacks.broken = [this](const Broken& b) { say("no connection, trying again: " + b.why.message); };
    callbacks.resumed = [this] { say({}); };
    callbacks.restarted = [this] { say("the model has changed on the server: loading the new one"); };
    StreamOptions options = options_;
    options.keep_chunks = true;
    Stream stream(url, options, std::move(callbacks));
    {
        const std::lock_guard lock(mutex_);
        stream_ = &stream;
        if (view_) stream.look(*view_);
        if (stopping_) stream.cancel();
    }
    const Result<Summary> summary = stream.wait();
    {
        const std::lock_guard lock(mutex_);
        stream_ = nullptr;
    }
    say(summary.ok() ? std::string() : summary.error().message);
    const Feed& feed = stream.feed();
    serve_requests(feed.decoder(), feed.state(),
                   [&](unsigned layer, double bytes) { return feed.decoder_of(layer, bytes); });
}

void LiveModel::read_file() {
    Decoder decoder(options_.limits);
    const Result<Bytes> file = mvw::read_file(place_);
    Result<void> fed = file.ok() ? Result<void>() : Result<void>(file.error());
    const auto less = [&](unsigned layer, double bytes) {
        return decoder_of_file(*file, options_.limits, layer, bytes);
    };
    constexpr std::size_t kSlice = 512;
    for (std::size_t at = 0; fed.ok() && at < file->size(); at += kSlice) {
        const std::uint64_t before = decoder.revision();
        const auto begun = std::chrono::steady_clock::now();
        fed = decoder.feed(ByteSpan(*file).subspan(at, std::min(kSlice, file->size() - at)));
        decode_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        note(decoder.state());
        if (!is_paced()) continue;
        if (decoder.revision() != before) draw(decoder, decoder.state(), less);
        if (!wait_for_pace(kSlice)) break;
    }
    if (!fed.ok()) say(place_ + ": " + fed.error().message);
    decoder.finish();
    serve_requests(decoder, decoder.state(), less);
}

bool LiveModel::is_paced() const {
    return options_.pace && std::isfinite(options_.pace->bytes_per_second);
}

// False where the model is to end.
bool LiveModel::wait_for_pace(double bytes) {
    const std::chrono::duration<double> time(bytes / options_.pace->bytes_per_second);
    std::unique_lock lock(mutex_);
    return !changed_.wait_for(lock, time, [this] { return stopping_; });
}

void LiveModel::serve_requests(const Decoder& decoder, const DecodeState& state, const LessOfIt& less) {
    std::unique_lock lock(mutex_);
    ended_ = true;
    for (++asked_; !stopping_;) {  // the last bytes are drawn in any case
        if (answered_ != asked_) {
            lock.unlock();
            draw(decoder, state, less);
            lock.lock();
        } else {
            changed_.wait(lock, [this] { return stopping_ || answered_ != asked_; });
        }
    }
}

void LiveModel::draw(const Decoder& decoder, const DecodeState& state, const LessOfIt& less) {
    LiveChoice choice;
    std::uint64_t version = 0;
    bool ended = false;
    {
        const std::lock_guard lock(mutex_);
        choice = shown_;
        version = asked_;
        ended = ended_;
    }
    const auto begun = std::chrono::steady_clock::now();
    if (choice.lines.level == 255 && !ended) choice.lines.level = state.level + 1;
    std::optional<Decoder> part;
    if (decoder.header() != nullptr && !choice.is_of_all(*decoder.header())) part = less(choice.layer, choice.bytes);
    Result<Drawable> drawable = make_drawable(part ? *part : decoder, choice.lines);
    auto frame = std::make_unique<LiveFrame>();
    if (drawable.ok()) {
        frame->drawable = std::move(*drawable);
        frame->state = part ? part->state() : state;
        frame->arrived = static_cast<double>(state.bytes);
        frame->draw_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        frame->decode_seconds = decode_seconds_;
        frame->file_bytes = decoder.header()->file_bytes();
        frame->layers = decoder.header()->layers;
        frame->parts = static_cast<unsigned>(decoder.header()->main_parts());
        frame->levels = finest_level(*decoder.header());
    }
    const std::lock_guard lock(mutex_);
    answered_ = version;
    frame->curve = curve_;
    if (drawable.ok()) frame_ = std::move(frame);
}

}  // namespace mvw::client
