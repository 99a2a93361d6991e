// A model that refines while a window shows it: network and decoding on threads of their own, the newest drawable
// handed over without waiting.
#pragma once
#include <array>
#include <condition_variable>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/client.h"
#include "client/drawable.h"

namespace mvw::client {

/// What a window wants to see.
struct LiveChoice {
    DrawableOptions lines;  // level 255: while bytes arrive, one beyond the finest that has details
    unsigned layer = 255;   // no finer one is used
    double bytes = std::numeric_limits<double>::infinity();  // no more of the file is used
    [[nodiscard]] bool is_of_all(const FileHeader& header) const;
};

/// What a window shows: a drawable and all that it says about it.
struct LiveFrame {
    Drawable drawable;
    DecodeState state;                            // of what is drawn
    double arrived = 0;                           // bytes, drawn or not
    double draw_seconds = 0, decode_seconds = 0;  // that making the drawable took, and all decoding so far
    unsigned levels = 0, layers = 0, parts = 0;   // of the file
    std::uint64_t file_bytes = 0;
    std::vector<std::array<float, 2>> curve;  // bytes, RMS error left, after each chunk so far
};

class LiveModel {
 public:
    /// `place`: a .mvw file or a URL. Errors come through message(). A file, too, comes at the options' pace.
    LiveModel(std::string place, StreamOptions options);
    ~LiveModel();
    LiveModel(const LiveModel&) = delete;
    LiveModel& operator=(const LiveModel&) = delete;

    // From the window's thread; none of them waits for network or decoding.

    /// The newest frame since the last call, if there is one.
    std::unique_ptr<LiveFrame> take();
    /// What drawables shall hold; the next one comes soon, also when all bytes are there.
    void show(const LiveChoice& choice);
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
    using LessOfIt = std::function<Decoder(unsigned layer, double bytes)>;
    void serve_requests(const Decoder& decoder, const DecodeState& state, const LessOfIt& less);
    void draw(const Decoder& decoder, const DecodeState& state, const LessOfIt& less);
    [[nodiscard]] bool is_paced() const;
    bool wait_for_pace(double bytes);
    void note(const DecodeState& state);
    void say(std::string message);

    const std::string place_;
    const StreamOptions options_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    LiveChoice shown_;
    double decode_seconds_ = 0;  // on the model's own thread
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
