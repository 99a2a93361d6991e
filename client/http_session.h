// One model's download from any HTTP server: the file itself, by Range where the server can, whole where it cannot.
// Answers and times in, actions out; the notices are those of session.h.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/session.h"
#include "codec/container/toc.h"
#include "server/protocol/schedule.h"

namespace mvw::client {

/// Ask for the file's bytes from `first` to `last`, or to its end; in place of any request before it.
struct Get {
    std::uint64_t first = 0;
    std::optional<std::uint64_t> last{};
    std::string if_range{};  // tag that the bytes before came with; empty: none
};
/// Drop the answer that is under way, and its connection.
struct Abandon {};

using HttpAction =
    std::variant<Get, Abandon, SetTimer, Opened, Received, Indexed, Satisfied, Broken, Resumed, Restarted, Failed>;
using HttpActions = std::vector<HttpAction>;

/// What the head of an answer says.
struct HttpAnswer {
    unsigned status = 0;
    std::string etag{};       // with its quotes; empty: none, or a weak one
    std::uint64_t first = 0;  // of a 206: the file's byte that the body begins with
};

/// Wants all of the model: reads the file from its beginning, since any prefix is a model. Wants parts of it (levels,
/// tiles, a target error): reads header and index, then the chunks of the schedule, neighbours together. Where the
/// server ignores Range, reads the whole file and hands out what is wanted; a target error cannot be met early then.
/// Owns no socket, thread or clock. Not thread-safe. A transport reports, after each Get: on_answer(), on_body() any
/// number of times, on_body_end(); or, at any point instead, on_disconnected() once; nothing after Abandon.
class HttpSession {
 public:
    HttpSession(Wants wants, const RetryPolicy& retry = {}, const Limits& limits = {}, std::uint32_t seed = 1);

    /// Before start(): what an earlier session received.
    void restore(Stored stored);
    HttpActions start(Clock::time_point now);
    HttpActions on_answer(const HttpAnswer& answer, Clock::time_point now);
    HttpActions on_body(ByteSpan in, Clock::time_point now);
    HttpActions on_body_end(Clock::time_point now);
    HttpActions on_disconnected(const Error& why, Clock::time_point now);
    HttpActions on_timer(Clock::time_point now);
    HttpActions want(Wants wants, Clock::time_point now);
    HttpActions cancel(Clock::time_point now);

    [[nodiscard]] const protocol::ChunkSet& held() const { return held_; }
    /// Of the answers so far; empty where they had none.
    [[nodiscard]] const std::string& etag() const { return etag_; }

 private:
    enum class State { New, Asking, Reading, Waiting, Asleep, Ended };
    enum class Goal { Prefix, Index, Chunks };  // what the present request is for

    void plan();
    void get(Goal goal, std::uint64_t first, std::optional<std::uint64_t> last);
    void plan_chunks();
    [[nodiscard]] bool needs_index() const;
    [[nodiscard]] bool is_wanted(const ChunkId& id) const;
    [[nodiscard]] protocol::Request request() const;
    void take_prefix();
    bool take_header();
    bool take_prefix_chunk();
    bool take_index();
    void take_chunks();
    void hand_out(std::uint32_t index, const ChunkId& id, float error, ByteSpan payload);
    bool damaged(std::uint32_t index);
    void drop(std::size_t bytes);
    void restart();
    void broken(Error why, bool answering);
    void fail(Error why);
    void satisfied(protocol::EndReason reason);
    void abandon();
    [[nodiscard]] std::optional<Clock::time_point> deadline() const;
    HttpActions flush();

    Wants wants_;
    RetryPolicy retry_;
    Limits limits_;
    HttpActions actions_;
    State state_ = State::New;
    Goal goal_ = Goal::Prefix;
    bool wanting_ = true, was_broken_ = false, stood_once_ = false;
    bool ranges_ = true;  // until the server has ignored one
    unsigned attempts_ = 0, restarts_ = 0;
    std::map<std::uint32_t, unsigned> damaged_;  // how often a chunk came with a wrong checksum
    Backoff backoff_;
    std::string etag_;

    std::optional<FileHeader> header_;
    std::optional<Toc> toc_;
    protocol::ChunkSet held_;
    std::uint64_t held_bytes_ = 0;  // header and payloads
    std::vector<Received> restored_;
    Bytes restored_header_;

    std::uint64_t first_bytes_ = 16u << 10;  // asked for to begin with where the index is needed
    std::uint64_t asked_first_ = 0;          // of the present request
    bool useful_ = false;                    // something of its answer was
    Bytes buffer_;                           // of the body, not taken yet
    std::uint64_t at_ = 0;                   // the file's offset of buffer_
    std::uint64_t skip_ = 0;                 // bytes of the body before at_: the server ignored the Range

    // Goal::Prefix: the walk through the file's chunks.
    std::uint64_t walked_ = 0;  // offset of the next chunk's head; 0 before the header
    ChunkId walked_id_;         // of the chunk before it
    std::uint32_t walked_chunks_ = 0;

    std::optional<protocol::Schedule> schedule_;
    std::optional<std::uint32_t> next_chunk_;  // taken from the schedule, not asked for yet
    std::vector<std::uint32_t> group_;         // Goal::Chunks: asked for and not come, in file order

    Clock::time_point now_{}, heard_{}, retry_at_{};
    std::optional<Clock::time_point> timer_;
};

}  // namespace mvw::client
