// A model that refines while a window shows it: network and decoding on threads of their own, the newest drawable
// handed over without waiting.
#pragma once
#include <array>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/client.h"
#include "client/drawable.h"

namespace mvw::client {

/// What a window shows: a drawable and all that it says about it.
struct LiveFrame {
    Drawable drawable;
    DecodeState state;
    double draw_seconds = 0;         // that making the drawable took
    unsigned levels = 0, parts = 0;  // of the file
    std::uint64_t file_bytes = 0;
    std::vector<std::array<float, 2>> curve;  // bytes, RMS error left, after each chunk so far
};

class LiveModel {
 public:
    /// `place`: a .mvw file or a URL. Errors come through message().
    LiveModel(std::string place, StreamOptions options);
    ~LiveModel();
    LiveModel(const LiveModel&) = delete;
    LiveModel& operator=(const LiveModel&) = delete;

    // From the window's thread; none of them waits for network or decoding.

    /// The newest frame since the last call, if there is one.
    std::unique_ptr<LiveFrame> take();
    /// What drawables shall hold; the next one comes soon, also when all bytes are there.
    void show(const DrawableOptions& options);
    /// Where it is looked at from: what is in view comes first. Ignored for files.
    void look(const View& view);
    /// For people: empty while all is well.
    [[nodiscard]] std::string message() const;
    /// Everything is there, or nothing more will come.
    [[nodiscard]] bool ended() const;
    /// ended(), and the last frame, drawn as show() said last, has been taken.
    [[nodiscard]] bool settled() const;

 private:
    void run();
    void stream(const Url& url);
    void read_file();
    void serve_requests(const Decoder& decoder);
    void draw(const Decoder& decoder, const DecodeState& state);
    void note(const DecodeState& state);
    void say(std::string message);

    const std::string place_;
    const StreamOptions options_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    DrawableOptions shown_;
    std::optional<View> view_;
    std::uint64_t asked_ = 1, answered_ = 0;  // versions of shown_
    std::unique_ptr<LiveFrame> frame_;
    std::string message_;
    std::vector<std::array<float, 2>> curve_;
    bool ended_ = false, stopping_ = false;
    Stream* stream_ = nullptr;  // while it runs
    std::thread thread_;        // last: it uses all of the above
};

}  // namespace mvw::client
