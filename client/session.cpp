#include "client/session.h"

#include <algorithm>
#include <utility>

#include "codec/container/crc32c.h"
#include "codec/container/toc.h"

namespace mvw::client {
namespace {

using namespace protocol;

constexpr unsigned kMaxDamage = 3;  // of one chunk; the file on the server is damaged then

MessageLimits accepted(const Limits& limits) {
    MessageLimits m;
    m.max_body_bytes = limits.max_chunk_bytes + static_cast<std::uint32_t>(kChunkFieldBytes);
    return m;
}

// Messages that a client sends and never takes.
template <typename M>
constexpr bool kFromClientOnly =
    std::is_same_v<M, Open> || std::is_same_v<M, Request> || std::is_same_v<M, Cancel> || std::is_same_v<M, GetIndex>;

Errc errc_of(ErrorCode code) {
    switch (code) {
        case ErrorCode::Malformed:
            return Errc::Malformed;
        case ErrorCode::Unsupported:
            return Errc::Unsupported;
        case ErrorCode::LimitExceeded:
            return Errc::LimitExceeded;
        default:
            return Errc::Io;
    }
}

// Errors that pass by themselves.
bool is_temporary(ErrorCode code) {
    return code == ErrorCode::TooBusy || code == ErrorCode::Timeout || code == ErrorCode::ShuttingDown ||
           code == ErrorCode::Internal;
}

}  // namespace

std::chrono::milliseconds Backoff::delay(unsigned attempt) {
    random_ = random_ * 1664525u + 1013904223u;  // Numerical Recipes' generator: spreads clients, keeps no secret
    const unsigned doublings = std::min(attempt - 1, 16u);
    const auto longest = std::min(retry_.first_delay * (std::int64_t{1} << doublings), retry_.longest_delay);
    return longest - longest * (random_ >> 24) / 1024;
}

Session::Session(std::string model, std::string token, Wants wants, const RetryPolicy& retry, const Limits& limits,
                 std::uint32_t seed)
    : model_(std::move(model)),
      token_(std::move(token)),
      wants_(std::move(wants)),
      retry_(retry),
      limits_(limits),
      input_(accepted(limits)),
      backoff_(retry, seed) {}

void Session::restore(Stored stored) {
    if (read_header(stored.header, limits_).ok() && stored.chunk_count > 0) stored_ = std::move(stored);
}

Actions Session::start(Clock::time_point now) {
    now_ = now;
    if (state_ != State::New) return {};
    if (stored_) tell_stored();
    connect();
    return flush();
}

void Session::tell_stored() {
    header_ = std::move(stored_->header);
    content_id_ = read_header(header_, limits_)->content_id;
    chunk_count_ = stored_->chunk_count;
    actions_.emplace_back(Opened{header_, chunk_count_, stored_->file_bytes, stored_->payload_bytes});
    for (Received& chunk : stored_->chunks) {
        if (chunk.index >= chunk_count_ || held_.contains(chunk.index)) continue;
        held_.insert(chunk.index);
        actions_.emplace_back(std::move(chunk));
    }
    stored_.reset();
}

Actions Session::on_connected(Clock::time_point now) {
    now_ = now;
    if (state_ != State::Connecting) return {};
    state_ = State::Greeting;
    stood_once_ = true;
    heard_ = pinged_ = now;
    input_.clear();
    Hello hello;
    hello.max_message_bytes = accepted(limits_).max_body_bytes;
    actions_.emplace_back(client::SendBytes{write_message(hello)});
    send_open();
    return flush();
}

Actions Session::on_bytes(ByteSpan in, Clock::time_point now) {
    now_ = now;
    if (state_ != State::Greeting && state_ != State::Open) return {};
    heard_ = now;
    input_.add(in);
    while (state_ == State::Greeting || state_ == State::Open) {
        Result<Message> message = input_.next();
        if (!message && message.error().code == Errc::NeedMoreData) break;
        if (!message) {
            fail({message.error().code, 0, "the server sent nonsense: " + message.error().message});
            break;
        }
        if (state_ == State::Greeting && !std::holds_alternative<Hello>(*message) &&
            !std::holds_alternative<ErrorMessage>(*message)) {
            fail({Errc::Malformed, 0, "the server does not greet"});
            break;
        }
        std::visit(
            [this](const auto& m) {
                using M = std::decay_t<decltype(m)>;
                if constexpr (kFromClientOnly<M>)
                    fail({Errc::Malformed, 0, "the server sent a message that only clients send"});
                else if constexpr (!std::is_same_v<M, Pong> && !std::is_same_v<M, Index>)
                    handle(m);
            },
            *message);
    }
    return flush();
}

Actions Session::on_disconnected(const Error& why, Clock::time_point now) {
    now_ = now;
    if (state_ != State::Connecting && state_ != State::Greeting && state_ != State::Open) return {};
    broken(why, false);
    return flush();
}

Actions Session::on_timer(Clock::time_point now) {
    now_ = now;
    timer_.reset();
    const std::optional<Clock::time_point> due = deadline();
    if (!due || *due > now) return flush();
    switch (state_) {
        case State::Waiting:
            connect();
            break;
        case State::Connecting:
            broken({Errc::Io, 0, "no answer to the connection"}, true);
            break;
        case State::Greeting:
        case State::Open:
            if (wanting_ || pinged_ > heard_) {
                broken({Errc::Io, 0, "nothing heard from the server"}, true);
            } else {
                pinged_ = now;
                actions_.emplace_back(client::SendBytes{write_message(Ping{1})});
            }
            break;
        case State::New:
        case State::Asleep:
        case State::Ended:
            break;
    }
    return flush();
}

Actions Session::want(Wants wants, Clock::time_point now) {
    now_ = now;
    if (state_ == State::Ended) return {};
    wants_ = std::move(wants);
    wanting_ = true;
    heard_ = now;  // the silence is counted from here
    // Until MODEL is there the OPEN that carries the old request cannot be told apart from this one: open again.
    if (state_ == State::Open && chunk_count_ != 0 && !restarting_)
        actions_.emplace_back(client::SendBytes{write_message(next_request())});
    else if (state_ == State::Greeting || state_ == State::Open)
        send_open();
    else if (state_ == State::Asleep)
        connect();
    return flush();
}

Actions Session::cancel(Clock::time_point now) {
    now_ = now;
    if (!wanting_ || state_ == State::Ended) return {};
    if (state_ == State::Greeting || state_ == State::Open) {
        actions_.emplace_back(client::SendBytes{write_message(Cancel{request_id_})});
    } else {
        if (state_ == State::Connecting) actions_.emplace_back(Disconnect{});
        state_ = State::Asleep;
        satisfied(EndReason::Cancelled);
    }
    return flush();
}

void Session::handle(const Hello& m) {
    if (state_ != State::Greeting) return fail({Errc::Malformed, 0, "the server greets twice"});
    if (m.version != kVersion || m.features != 0)
        return fail({Errc::Unsupported, 0,
                     "the server speaks version " + std::to_string(m.version) + ", this client version " +
                         std::to_string(kVersion)});
    state_ = State::Open;
}

void Session::handle(const Model& m) {
    Result<FileHeader> header = read_header(m.header, limits_);
    if (!header) return fail({header.error().code, 0, "the model's header: " + header.error().message});
    if (header->header_bytes != m.header.size())
        return fail({Errc::Malformed, 0, "the model's header has another size than it says"});
    if (m.chunk_count == 0 || m.chunk_count > limits_.max_chunks)
        return fail({Errc::LimitExceeded, 0,
                     "the model has " + std::to_string(m.chunk_count) + " chunks, limit is " +
                         std::to_string(limits_.max_chunks)});
    const bool same = header->content_id == content_id_ && m.chunk_count == chunk_count_;
    if (chunk_count_ != 0 && !same) return restart();
    restarting_ = false;
    if (chunk_count_ == 0) {
        content_id_ = header->content_id;
        chunk_count_ = m.chunk_count;
        header_.assign(m.header.begin(), m.header.end());
        actions_.emplace_back(Opened{header_, m.chunk_count, m.file_bytes, m.payload_bytes});
    }
    if (std::exchange(was_broken_, false)) actions_.emplace_back(Resumed{});
}

void Session::handle(const Chunk& m) {
    if (restarting_) return;
    if (m.index >= chunk_count_) return fail({Errc::Malformed, 0, "the server sent a chunk that the model lacks"});
    if (held_.contains(m.index)) return;  // asked for anew while it was under way
    if (crc32c(m.payload) != m.crc32c) {
        const std::string which = "chunk " + std::to_string(m.index) + " came damaged";
        if (++damaged_[m.index] >= kMaxDamage) return fail({Errc::Malformed, 0, which + " each time"});
        return broken({Errc::Malformed, 0, which}, true);
    }
    held_.insert(m.index);
    attempts_ = 0;
    actions_.emplace_back(Received{m.index, m.id, m.crc32c, m.error, Bytes(m.payload.begin(), m.payload.end())});
}

void Session::handle(const End& m) {
    if (m.id == request_id_ && wanting_ && !restarting_) satisfied(m.reason);
}

void Session::handle(const ErrorMessage& m) {
    if (m.code == ErrorCode::Changed) return restart();
    const Error why{errc_of(m.code), 0, "the server says: " + m.sentence};
    is_temporary(m.code) ? broken(why, true) : fail(why);
}

void Session::handle(const Ping& m) {
    actions_.emplace_back(client::SendBytes{write_message(Pong{m.nonce})});
}

void Session::connect() {
    state_ = State::Connecting;
    begun_ = now_;
    actions_.emplace_back(Connect{});
}

void Session::send_open() {
    Open open{model_, token_, {}, next_request()};
    if (!held_.empty()) open.content_id = content_id_;
    actions_.emplace_back(client::SendBytes{write_message(open)});
}

// Another model has this name now: start over, on the same connection.
void Session::restart() {
    if (++restarts_ > retry_.restarts) return fail({Errc::Io, 0, "the model keeps changing on the server"});
    held_.clear();
    damaged_.clear();
    header_.clear();
    content_id_ = {};
    chunk_count_ = 0;
    was_broken_ = false;
    restarting_ = true;
    actions_.emplace_back(Restarted{});
    send_open();
}

void Session::broken(Error why, bool connected) {
    if (connected) actions_.emplace_back(Disconnect{});
    if (!wanting_ && state_ == State::Open) {  // nothing was due: connect again when something is
        state_ = State::Asleep;
        was_broken_ = true;
        return;
    }
    if (++attempts_ >= (stood_once_ ? retry_.attempts : retry_.first_attempts)) {
        state_ = State::Ended;
        why.message += ", given up after " + std::to_string(attempts_) + " attempts";
        actions_.emplace_back(Failed{std::move(why)});
        return;
    }
    state_ = State::Waiting;
    was_broken_ = chunk_count_ != 0;
    const std::chrono::milliseconds delay = backoff_.delay(attempts_);
    retry_at_ = now_ + delay;
    actions_.emplace_back(Broken{std::move(why), delay});
}

void Session::fail(Error why) {
    if (state_ == State::Greeting || state_ == State::Open) actions_.emplace_back(Disconnect{});
    state_ = State::Ended;
    actions_.emplace_back(Failed{std::move(why)});
}

void Session::satisfied(EndReason reason) {
    wanting_ = false;
    pinged_ = now_;
    actions_.emplace_back(Satisfied{reason});
}

Request Session::next_request() {
    Request r;
    r.id = ++request_id_;
    r.max_level = wants_.max_level;
    r.max_layer = wants_.max_layer;
    r.other_priority = wants_.other_priority;
    r.target_error = wants_.target_error;
    r.byte_budget = wants_.byte_budget;
    r.tiles = wants_.tiles;
    r.held = held_;
    return r;
}

std::optional<Clock::time_point> Session::deadline() const {
    switch (state_) {
        case State::Waiting:
            return retry_at_;
        case State::Connecting:
            return begun_ + retry_.connect_time;
        case State::Greeting:
        case State::Open:
            if (wanting_) return std::max(heard_, begun_) + retry_.silence_time;
            return pinged_ > heard_ ? pinged_ + retry_.silence_time : std::max(heard_, pinged_) + retry_.ping_every;
        case State::New:
        case State::Asleep:
        case State::Ended:
            break;
    }
    return std::nullopt;
}

Actions Session::flush() {
    return gathered(actions_, timer_, deadline());
}

}  // namespace mvw::client
