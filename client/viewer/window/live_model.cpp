#include "client/viewer/window/live_model.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "codec/mesh/io/files.h"

namespace mvw::client {

LiveModel::LiveModel(std::string place, StreamOptions options)
    : place_(std::move(place)), options_(std::move(options)), thread_([this] { run(); }) {}

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

void LiveModel::show(const DrawableOptions& options) {
    const std::lock_guard lock(mutex_);
    shown_ = options;
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
        if (r.waiting == 0) draw(decoder, r.state);
    };
    callbacks.broken = [this](const Broken& b) { say("no connection, trying again: " + b.why.message); };
    callbacks.resumed = [this] { say({}); };
    callbacks.restarted = [this] { say("the model has changed on the server: loading the new one"); };
    Stream stream(url, options_, std::move(callbacks));
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
    serve_requests(stream.feed().decoder());
}

void LiveModel::read_file() {
    Decoder decoder(options_.limits);
    const Result<Bytes> file = mvw::read_file(place_);
    Result<void> fed = file.ok() ? Result<void>() : Result<void>(file.error());
    constexpr std::size_t kSlice = 512;
    for (std::size_t at = 0; fed.ok() && at < file->size(); at += kSlice) {
        fed = decoder.feed(ByteSpan(*file).subspan(at, std::min(kSlice, file->size() - at)));
        note(decoder.state());
    }
    if (!fed.ok()) say(place_ + ": " + fed.error().message);
    decoder.finish();
    serve_requests(decoder);
}

void LiveModel::serve_requests(const Decoder& decoder) {
    std::unique_lock lock(mutex_);
    ended_ = true;
    for (++asked_; !stopping_;) {  // the last bytes are drawn in any case
        if (answered_ != asked_) {
            lock.unlock();
            draw(decoder, decoder.state());
            lock.lock();
        } else {
            changed_.wait(lock, [this] { return stopping_ || answered_ != asked_; });
        }
    }
}

void LiveModel::draw(const Decoder& decoder, const DecodeState& state) {
    DrawableOptions options;
    std::uint64_t version = 0;
    {
        const std::lock_guard lock(mutex_);
        options = shown_;
        version = asked_;
    }
    const auto begun = std::chrono::steady_clock::now();
    Result<Drawable> drawable = make_drawable(decoder, options);
    auto frame = std::make_unique<LiveFrame>();
    if (drawable.ok()) {
        frame->drawable = std::move(*drawable);
        frame->state = state;
        frame->draw_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        frame->file_bytes = decoder.header()->file_bytes();
        frame->parts = static_cast<unsigned>(decoder.header()->parts.size());
        for (const PartInfo& part : decoder.header()->parts)
            frame->levels = std::max<unsigned>(frame->levels, part.levels);
    }
    const std::lock_guard lock(mutex_);
    answered_ = version;
    frame->curve = curve_;
    if (drawable.ok()) frame_ = std::move(frame);
}

}  // namespace mvw::client
