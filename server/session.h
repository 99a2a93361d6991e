// One peer's side of the native protocol on the server. Bytes and times in, actions out; PROTOCOL.md 4 is normative.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "server/limits.h"
#include "server/model_source.h"
#include "server/protocol/message_stream.h"
#include "server/protocol/schedule.h"

namespace mvw::server {

using Clock = std::chrono::steady_clock;

/// What a transport has to do, in order.
struct SendBytes {
    Bytes bytes;
};
/// Bytes of a model's file, read only when they are about to be sent.
struct SendRange {
    ModelPtr model;
    std::uint64_t offset = 0;
    std::uint32_t length = 0;
};
/// Call on_timer() at that time; takes the place of the one before.
struct SetTimer {
    Clock::time_point at;
};
/// Call on_model_known() once it is known whether there is a model of that name.
struct AwaitModel {
    std::string name;
};
/// Send what is queued, then close. Nothing follows.
struct Close {
    std::string reason;  // for the log
};
using Action = std::variant<SendBytes, SendRange, SetTimer, AwaitModel, Close>;
using Actions = std::vector<Action>;

/// What one peer has had so far.
struct SessionStats {
    std::uint64_t messages = 0, requests = 0, chunks = 0, errors = 0;
    std::uint64_t malformed = 0, timeouts = 0, forbidden = 0;  // of those errors; timeouts also without a word
    std::uint64_t queued_bytes = 0;                            // by actions, heads included
};

/// One peer's protocol state. Owns no socket, thread or clock, so a test drives it with literals. Not thread-safe: one
/// strand for each peer. After a Close every call gives no actions.
class Session {
 public:
    /// `limits` outlives the session.
    Session(OpenModel open, const ServerLimits& limits, CheckToken allow = {});

    Actions on_start(Clock::time_point now);
    Actions on_bytes(ByteSpan in, Clock::time_point now);
    Actions on_sent(std::size_t bytes, Clock::time_point now);  // the network took them: room again
    Actions on_timer(Clock::time_point now);
    Actions on_model_known(Clock::time_point now);
    /// A SendRange could not be read; what of it was sent before is cut short, so no message can follow.
    Actions on_read_error(const Error& error);
    /// The server stops: the present request is finished, no other one is taken.
    Actions on_drain(Clock::time_point now);

    [[nodiscard]] const SessionStats& stats() const { return stats_; }
    [[nodiscard]] const std::string& model_name() const { return model_name_; }
    [[nodiscard]] std::size_t queued_bytes() const { return queued_; }

 private:
    void handle(const protocol::Hello& m);
    void handle(const protocol::Open& m);
    void handle(const protocol::Request& m);
    void handle(const protocol::Cancel& m);
    void handle(const protocol::GetIndex& m);
    void handle(const protocol::Ping& m);
    void handle(const protocol::Pong& m);
    void handle_message(const protocol::Message& message);

    void open_model(const protocol::Open& m);
    void start_request(protocol::Request request);
    void pump();
    void send_model();
    void send_index();
    void send_chunk(std::uint32_t index);
    void send_end(protocol::EndReason reason);
    void answer(Bytes message);  // a small message, counted against the hard limit
    void queue_bytes(Bytes bytes);
    void queue_range(std::uint64_t offset, std::uint32_t length);
    void count_queued(std::size_t bytes, bool is_answer);
    void fail(protocol::ErrorCode code, std::string sentence);  // ERROR; closes unless the code is recoverable
    void close(std::string reason);
    void forget_model();
    bool take_token(Clock::time_point now);
    Actions flush(Clock::time_point now);
    [[nodiscard]] Clock::time_point deadline() const;

    OpenModel open_;
    CheckToken allow_;
    const ServerLimits& limits_;
    protocol::MessageStream input_;
    Actions actions_;
    SessionStats stats_;

    bool greeted_ = false, closed_ = false, draining_ = false;
    std::uint32_t peer_max_body_ = 0;
    std::string model_name_;
    ModelPtr model_;
    std::optional<protocol::Open> opening_;       // its model is being looked up
    protocol::ChunkSet sent_;                     // held by the peer, or on its way
    std::optional<protocol::Schedule> schedule_;  // the present request
    bool model_wanted_ = false, index_wanted_ = false;
    std::uint32_t request_chunks_ = 0;
    std::uint64_t request_bytes_ = 0;

    std::size_t queued_ = 0, queued_answers_ = 0;
    std::deque<std::pair<std::size_t, bool>> queue_;  // sizes of what is queued; true for answers

    double tokens_ = 0;
    Clock::time_point tokens_at_{};
    Clock::time_point now_{}, last_heard_{}, last_progress_{};
    std::optional<Clock::time_point> message_begun_;  // when the part of a message that waits for its rest began
    std::optional<Clock::time_point> timer_;          // last SetTimer
};

}  // namespace mvw::server
