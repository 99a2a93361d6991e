// The client's side of the native protocol, over as many connections as it takes: wants, receipts, retries. Bytes and
// times in, actions out; PROTOCOL.md 4 is normative.
#pragma once
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "codec/limits.h"
#include "server/protocol/message_stream.h"

namespace mvw::client {

using Clock = std::chrono::steady_clock;

/// What of a model is wanted; the defaults mean all of it. Fields as in protocol::Request.
struct Wants {
    std::uint8_t max_level = 255, max_layer = 255;
    float target_error = 0;
    std::uint64_t byte_budget = 0;
    std::uint8_t other_priority = 1;
    std::vector<protocol::TilePriority> tiles{};
};

/// When to try again and when to give up.
struct RetryPolicy {
    unsigned attempts = 8;        // in a row without a new chunk; then the session fails
    unsigned first_attempts = 4;  // the same before any connection has stood
    std::chrono::milliseconds first_delay{100}, longest_delay{5'000};  // doubled each time, less up to a quarter
    std::chrono::milliseconds connect_time{10'000};
    std::chrono::milliseconds silence_time{30'000};  // while something is due: the connection counts as broken
    std::chrono::milliseconds ping_every{60'000};    // while nothing is due
    unsigned restarts = 3;                           // after the model has changed
};

/// Delays between attempts: doubled each time, less a random part of up to a quarter, so that the clients of one server
/// do not come back together.
class Backoff {
 public:
    Backoff(const RetryPolicy& retry, std::uint32_t seed) : retry_(retry), random_(seed) {}
    std::chrono::milliseconds delay(unsigned attempt);  // the first is 1

 private:
    RetryPolicy retry_;
    std::uint32_t random_;
};

// What a transport has to do, in order.
struct Connect {};
struct SendBytes {
    Bytes bytes;
};
struct SetTimer {
    Clock::time_point at;  // in place of the one before
};
struct Disconnect {};

// What the owner is told, in order.

/// The model is open; told again after Restarted.
struct Opened {
    Bytes header;
    std::uint32_t chunk_count = 0;
    std::uint64_t file_bytes = 0, payload_bytes = 0;
};
/// Received::error where only the chunk itself tells it.
inline constexpr float kUnknownError = -1;

/// A chunk that was not held before; its checksum is right.
struct Received {
    std::uint32_t index = 0;
    ChunkId id;
    std::uint32_t crc32c = 0;
    float error = 0;  // left once it and all before it in file order are there, fraction of the diagonal
    Bytes payload;
};
/// The errors of all chunks, once the file's index has come (HTTP): in place of what Received said of them.
struct Indexed {
    std::vector<float> errors;
};
/// What an earlier session opened and received.
struct Stored {
    Bytes header;
    std::uint32_t chunk_count = 0;
    std::uint64_t file_bytes = 0, payload_bytes = 0;
    std::string etag{};  // HTTP
    std::vector<Received> chunks{};
};
/// All that is wanted and can be had is there.
struct Satisfied {
    protocol::EndReason reason = protocol::EndReason::Complete;
};
/// The connection is gone; it will be tried again.
struct Broken {
    Error why;
    std::chrono::milliseconds retry_in{};
};
/// Connected again after Broken; what is held is kept.
struct Resumed {};
/// The server has another model under this name now: all that was received is void.
struct Restarted {};
/// Nothing more will come.
struct Failed {
    Error why;
};

using Action = std::variant<Connect, SendBytes, SetTimer, Disconnect, Opened, Received, Satisfied, Broken, Resumed,
                            Restarted, Failed>;
using Actions = std::vector<Action>;

/// Hands out what a session has gathered. `timer`, which its owner keeps, is moved to what is due only where it would
/// fire too late: one that fires early looks again.
template <typename AnyAction>
std::vector<AnyAction> gathered(std::vector<AnyAction>& actions, std::optional<Clock::time_point>& timer,
                                const std::optional<Clock::time_point>& due) {
    if (due && (!timer || *due < *timer)) {
        timer = due;
        actions.emplace_back(SetTimer{*due});
    }
    return std::exchange(actions, {});
}

/// One model's download. Owns no socket, thread or clock. Not thread-safe.
/// A transport reports exactly one on_connected() or on_disconnected() after each Connect, and one on_disconnected()
/// after a connection that stood ends for any reason but Disconnect.
class Session {
 public:
    /// `seed` varies the retry delays, so that many clients of one server do not come back together.
    Session(std::string model, std::string token, Wants wants, const RetryPolicy& retry = {}, const Limits& limits = {},
            std::uint32_t seed = 1);

    /// Before start(), which then tells it all again: what an earlier session received. Dropped when the server has
    /// another model under this name.
    void restore(Stored stored);
    Actions start(Clock::time_point now);
    Actions on_connected(Clock::time_point now);
    Actions on_bytes(ByteSpan in, Clock::time_point now);
    Actions on_disconnected(const Error& why, Clock::time_point now);
    Actions on_timer(Clock::time_point now);

    /// Wants something else from now on; what is under way still comes.
    Actions want(Wants wants, Clock::time_point now);
    /// Wants nothing more. Satisfied (Cancelled) follows, from the server where it can be asked.
    Actions cancel(Clock::time_point now);

    [[nodiscard]] const protocol::ChunkSet& held() const { return held_; }

 private:
    enum class State { New, Connecting, Greeting, Open, Waiting, Asleep, Ended };  // PROTOCOL.md 4.2

    void handle(const protocol::Hello& m);
    void handle(const protocol::Model& m);
    void handle(const protocol::Chunk& m);
    void handle(const protocol::End& m);
    void handle(const protocol::ErrorMessage& m);
    void handle(const protocol::Ping& m);

    void tell_stored();
    void connect();
    void send_open();
    void restart();
    void broken(Error why, bool connected);
    void fail(Error why);
    void satisfied(protocol::EndReason reason);
    [[nodiscard]] protocol::Request next_request();
    Actions flush();
    [[nodiscard]] std::optional<Clock::time_point> deadline() const;

    std::string model_, token_;
    Wants wants_;
    RetryPolicy retry_;
    Limits limits_;
    protocol::MessageStream input_;
    Actions actions_;

    State state_ = State::New;
    bool wanting_ = true;      // a request is unanswered
    bool was_broken_ = false;  // Resumed is due
    bool stood_once_ = false;  // a connection has
    bool restarting_ = false;  // chunks until MODEL are of the model that is gone
    std::uint32_t request_id_ = 0;
    unsigned attempts_ = 0, restarts_ = 0;
    std::map<std::uint32_t, unsigned> damaged_;  // how often a chunk came with a wrong checksum
    Backoff backoff_;

    std::optional<Stored> stored_;  // until start()
    Bytes header_;                  // of the model as first opened
    protocol::ContentId content_id_{};
    std::uint32_t chunk_count_ = 0;
    protocol::ChunkSet held_;

    Clock::time_point now_{}, retry_at_{}, begun_{}, heard_{}, pinged_{};
    std::optional<Clock::time_point> timer_;
};

}  // namespace mvw::client
