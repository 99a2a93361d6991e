// Chunks in, refinements out: decodes on a thread of its own and tells the owner what changed.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>

#include "client/session.h"
#include "codec/decoder.h"

namespace mvw::client {

class Feed;

/// A better model than before.
struct Refinement {
    ChunkId chunk;               // what brought it
    DecodeState state;           // after it
    double seconds = 0;          // since the feed began
    double decode_seconds = 0;   // of these, what decoding took
    std::size_t waiting = 0;     // chunks that have arrived and are not decoded yet: a busy owner skips to the last
    const Feed* feed = nullptr;  // for its decoder_of(), there and then
};

/// Owns the decoder and the thread that feeds it.
class Feed {
 public:
    /// Called on the feed's thread, which alone uses the decoder: take a mesh there and then, or leave it.
    using OnRefined = std::function<void(const Refinement&, const Decoder&)>;

    /// keep_chunks: payloads are kept for file() and decoder_of().
    Feed(const Limits& limits, bool keep_chunks, OnRefined on_refined);
    ~Feed();  // drops what waits
    Feed(const Feed&) = delete;
    Feed& operator=(const Feed&) = delete;

    /// Hands over what a session told. Waits while too many bytes are undecoded, so that a fast network does not fill
    /// the memory of a slow machine.
    void push(Opened opened);
    void push(Received chunk);
    void push(Indexed indexed);
    void push(Restarted);
    /// Returns once all that was pushed has been decoded.
    void wait_idle();
    /// Drops what waits; push() and wait_idle() return at once from now on.
    void stop();

    // Below: only from within OnRefined, or while nothing is pushed and after wait_idle().

    [[nodiscard]] const Decoder& decoder() const { return *decoder_; }
    /// The decoder's, with an error that holds for any choice of chunks: that which the file states for the longest row
    /// of chunks from its beginning that have all come (more chunks never make it worse).
    [[nodiscard]] DecodeState state() const;
    /// Seconds from the feed's beginning until there was a mesh; none where there is none.
    [[nodiscard]] std::optional<double> first_mesh_seconds() const { return first_mesh_; }
    /// The first thing that the decoder refused; what came before and after it is still used.
    [[nodiscard]] const std::optional<Error>& error() const { return error_; }
    /// A valid .mvw file of the chunks received, in file order. NeedMoreData before the header is there.
    [[nodiscard]] Result<Bytes> file() const;
    /// A decoder of less: of the kept chunks in file order as far as `bytes` go, and of these no layer above `layer`.
    [[nodiscard]] Decoder decoder_of(unsigned layer, double bytes) const;

 private:
    using Item = std::variant<Opened, Received, Indexed, Restarted>;
    void push_item(Item item);
    void run();
    void take(Opened& opened);
    void take(Received& chunk);
    void take(Indexed& indexed);
    void take(Restarted&);
    [[nodiscard]] double seconds() const;

    const Limits limits_;
    const bool keep_chunks_;
    const OnRefined on_refined_;
    const Clock::time_point begun_ = Clock::now();

    std::optional<Decoder> decoder_;
    std::optional<double> first_mesh_;
    double decode_seconds_ = 0;
    std::optional<Error> error_;
    Bytes header_;
    std::uint32_t row_ = 0;                 // chunks from the file's beginning that have all come
    float row_error_ = 1;                   // left by them
    std::map<std::uint32_t, float> ahead_;  // errors stated by chunks that came and are not in the row yet
    std::map<std::uint32_t, Received> kept_;

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Item> queue_;
    std::size_t queued_bytes_ = 0;
    bool busy_ = false, stopped_ = false;
    std::thread thread_;  // last: it uses all of the above
};

}  // namespace mvw::client
