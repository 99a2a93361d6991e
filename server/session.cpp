#include "server/session.h"

#include <algorithm>
#include <utility>

namespace mvw::server {
namespace {

using namespace protocol;

ErrorCode wire_code(Errc code) {
    switch (code) {
        case Errc::Unsupported:
            return ErrorCode::Unsupported;
        case Errc::LimitExceeded:
            return ErrorCode::LimitExceeded;
        case Errc::Io:
            return ErrorCode::NotFound;
        default:
            return ErrorCode::Malformed;
    }
}

// Messages that a server sends and never takes.
template <typename M>
constexpr bool kFromServerOnly = std::is_same_v<M, Model> || std::is_same_v<M, Chunk> || std::is_same_v<M, End> ||
                                 std::is_same_v<M, Index> || std::is_same_v<M, ErrorMessage>;

}  // namespace

Session::Session(OpenModel open, const ServerLimits& limits, CheckToken allow)
    : open_(std::move(open)),
      allow_(std::move(allow)),
      limits_(limits),
      input_(limits.message),
      tokens_(limits.message_burst) {}

Actions Session::on_start(Clock::time_point now) {
    tokens_at_ = last_heard_ = last_progress_ = now;
    message_begun_ = now;  // HELLO is due
    return flush(now);
}

Actions Session::on_bytes(ByteSpan in, Clock::time_point now) {
    if (closed_) return {};
    now_ = last_heard_ = now;
    input_.add(in);
    bool completed = false;
    while (!closed_) {
        Result<Message> message = input_.next();
        if (!message) {
            if (message.error().code != Errc::NeedMoreData)
                fail(wire_code(message.error().code), message.error().message);
            break;
        }
        completed = true;
        if (!take_token(now)) {
            fail(ErrorCode::TooBusy, "too many messages a second");
            break;
        }
        handle_message(*message);
    }
    if (input_.partial()) {
        if (completed || !message_begun_) message_begun_ = now;
    } else if (greeted_) {
        message_begun_.reset();
    }
    if (!closed_) pump();
    return flush(now);
}

Actions Session::on_sent(std::size_t bytes, Clock::time_point now) {
    if (closed_) return {};
    now_ = last_progress_ = now;
    queued_ -= std::min(bytes, queued_);
    while (bytes > 0 && !queue_.empty()) {
        auto& [size, is_answer] = queue_.front();
        const std::size_t taken = std::min(bytes, size);
        bytes -= taken;
        size -= taken;
        if (is_answer) queued_answers_ -= taken;
        if (size == 0) queue_.pop_front();
    }
    pump();
    return flush(now);
}

Actions Session::on_timer(Clock::time_point now) {
    if (closed_) return {};
    now_ = now;
    timer_.reset();
    if (deadline() <= now) {
        if (queued_ > 0 && last_progress_ + limits_.stall_time <= now) {
            ++stats_.timeouts;
            close("peer does not read");
        } else if (message_begun_ && *message_begun_ + limits_.header_time <= now) {
            fail(ErrorCode::Timeout, greeted_ ? "the message took too long" : "no HELLO in time");
        } else {
            fail(ErrorCode::Timeout, "idle for too long");
        }
    }
    return flush(now);
}

Actions Session::on_model_known(Clock::time_point now) {
    if (closed_ || !opening_) return {};
    now_ = last_heard_ = now;  // the peer had to wait for us
    const Open m = *std::exchange(opening_, std::nullopt);
    open_model(m);
    if (!closed_) pump();
    return flush(now);
}

Actions Session::on_read_error(const Error& error) {
    if (closed_) return {};
    ++stats_.errors;
    close("model cannot be read: " + error.message);
    return std::exchange(actions_, {});
}

Actions Session::on_drain(Clock::time_point now) {
    if (closed_) return {};
    now_ = now;
    draining_ = true;
    if (!schedule_ && !opening_) fail(ErrorCode::ShuttingDown, "the server stops");
    return flush(now);
}

void Session::handle_message(const Message& message) {
    ++stats_.messages;
    if (!greeted_ && !std::holds_alternative<Hello>(message))
        return fail(ErrorCode::Malformed, "the first message is not HELLO");
    std::visit(
        [this](const auto& m) {
            if constexpr (kFromServerOnly<std::decay_t<decltype(m)>>)
                fail(ErrorCode::Malformed, "a message that only servers send");
            else
                handle(m);
        },
        message);
}

void Session::handle(const Hello& m) {
    if (greeted_) return fail(ErrorCode::Malformed, "HELLO twice");
    greeted_ = true;
    if (m.min_version > kVersion || m.version < kVersion)
        return fail(ErrorCode::Unsupported, "this server speaks version " + std::to_string(kVersion) + " alone");
    if (m.features != 0) return fail(ErrorCode::Unsupported, "unknown required feature");
    peer_max_body_ = m.max_message_bytes;
    Hello mine;
    mine.max_message_bytes = limits_.message.max_body_bytes;
    mine.keep_alive_seconds = static_cast<std::uint16_t>(
        std::clamp<std::int64_t>(std::chrono::ceil<std::chrono::seconds>(limits_.idle_time).count(), 0, 0xFFFF));
    answer(write_message(mine));
}

void Session::handle(const Open& m) {
    if (draining_) return fail(ErrorCode::ShuttingDown, "the server stops");
    if (m.content_id == ContentId{} && !m.request.held.empty())
        return fail(ErrorCode::Malformed, "chunks are held, and no model is named that they are of");
    forget_model();
    // Before the look-up: whoever may not have a model does not learn whether it is there.
    if (const Result<void> allowed = allow_ ? allow_(m.token, m.model) : Result<void>{}; !allowed)
        return fail(ErrorCode::Forbidden, allowed.error().message);
    open_model(m);
}

void Session::open_model(const Open& m) {
    Result<ModelPtr> found = open_(m.model);
    if (!found && found.error().code == Errc::NeedMoreData) {
        opening_ = m;
        actions_.emplace_back(AwaitModel{m.model});
        return;
    }
    if (!found) {
        const ErrorCode code = wire_code(found.error().code);
        return fail(code == ErrorCode::NotFound ? code : ErrorCode::Internal, found.error().message);
    }
    ModelPtr model = std::move(found).value();
    if (m.content_id != ContentId{} && m.content_id != model->toc().header.content_id)
        return fail(ErrorCode::Changed, "the model is not the one that the held chunks are of");
    if (model->header().size() + 20 > peer_max_body_)
        return fail(ErrorCode::LimitExceeded, "the model's header is larger than the peer accepts");
    model_name_ = m.model;
    model_ = std::move(model);
    model_wanted_ = true;
    start_request(m.request);
}

void Session::handle(const Request& m) {
    if (draining_) return fail(ErrorCode::ShuttingDown, "the server stops");
    if (opening_) {
        opening_->request = m;
        return;
    }
    if (!model_) return fail(ErrorCode::NotFound, "no model is open");
    start_request(m);
}

void Session::handle(const Cancel& m) {
    if (opening_ && opening_->request.id == m.id) {
        opening_.reset();
        answer(write_message(End{m.id, EndReason::Cancelled, 0, 0}));
        if (draining_ && !closed_) fail(ErrorCode::ShuttingDown, "the server stops");
        return;
    }
    // A CANCEL that crosses the END of its request is no fault.
    if (!schedule_ || schedule_->request_id() != m.id) return;
    if (model_wanted_) send_model();
    send_end(EndReason::Cancelled);
}

void Session::handle(const GetIndex&) {
    if (opening_) {
        index_wanted_ = true;
        return;
    }
    if (!model_) return fail(ErrorCode::NotFound, "no model is open");
    if (model_->toc().header.index_bytes > peer_max_body_)
        return fail(ErrorCode::LimitExceeded, "the model's index is larger than the peer accepts");
    index_wanted_ = true;
}

void Session::handle(const Ping& m) {
    answer(write_message(Pong{m.nonce}));
}

void Session::handle(const Pong&) {}  // being heard was the point

void Session::start_request(Request request) {
    ++stats_.requests;
    const auto held = request.held.ranges();
    if (!held.empty() && held.back().last >= model_->toc().chunks.size())
        return fail(ErrorCode::Malformed, "a held chunk that the model does not have");
    sent_.merge(request.held);
    request.held = sent_;  // what is on its way counts as held
    request_chunks_ = 0;
    request_bytes_ = 0;
    schedule_.emplace(model_->toc(), std::move(request));
}

// Queues what is due until the soft limit: the peer's reading speed paces everything but answers.
void Session::pump() {
    if (!model_ || queued_ >= limits_.soft_queue_bytes) return;
    if ((schedule_ || index_wanted_) && !model_->intact()) {
        forget_model();
        return fail(ErrorCode::Changed, "the model's file was overwritten");
    }
    if (model_wanted_) send_model();
    if (index_wanted_) send_index();
    while (!closed_ && schedule_ && queued_ < limits_.soft_queue_bytes) {
        if (const std::optional<std::uint32_t> index = schedule_->next(sent_))
            send_chunk(*index);
        else
            send_end(schedule_->end_reason());
    }
}

void Session::send_model() {
    model_wanted_ = false;
    Model m;
    m.chunk_count = static_cast<std::uint32_t>(model_->toc().chunks.size());
    m.file_bytes = model_->file_bytes();
    m.payload_bytes = model_->payload_bytes();
    m.header = model_->header();
    queue_bytes(write_message(m));
}

void Session::send_index() {
    index_wanted_ = false;
    const FileHeader& header = model_->toc().header;
    queue_bytes(write_index_head(header.index_bytes));
    queue_range(header.index_offset, header.index_bytes);
}

void Session::send_chunk(std::uint32_t index) {
    const ChunkEntry& chunk = model_->toc().chunks[index];
    if (chunk.length + kChunkFieldBytes > peer_max_body_)
        return fail(ErrorCode::LimitExceeded, "a chunk is larger than the peer accepts");
    queue_bytes(write_chunk_head(index, chunk));
    queue_range(chunk.offset, chunk.length);
    sent_.insert(index);
    ++request_chunks_;
    request_bytes_ += chunk.length;
    ++stats_.chunks;
}

void Session::send_end(EndReason reason) {
    const End end{schedule_->request_id(), reason, request_chunks_, request_bytes_};
    schedule_.reset();
    answer(write_message(end));
    if (draining_ && !closed_) fail(ErrorCode::ShuttingDown, "the server stops");
}

void Session::answer(Bytes message) {
    if (closed_) return;
    queued_answers_ += message.size();
    count_queued(message.size(), true);
    actions_.emplace_back(SendBytes{std::move(message)});
    if (queued_answers_ > limits_.hard_queue_bytes) close("peer asks and does not read");
}

void Session::queue_bytes(Bytes bytes) {
    count_queued(bytes.size(), false);
    actions_.emplace_back(SendBytes{std::move(bytes)});
}

void Session::queue_range(std::uint64_t offset, std::uint32_t length) {
    if (length == 0) return;
    count_queued(length, false);
    actions_.emplace_back(SendRange{model_, offset, length});
}

void Session::count_queued(std::size_t bytes, bool is_answer) {
    if (queued_ == 0) last_progress_ = now_;  // the stall is counted from here
    queued_ += bytes;
    stats_.queued_bytes += bytes;
    if (!queue_.empty() && queue_.back().second == is_answer)
        queue_.back().first += bytes;
    else
        queue_.emplace_back(bytes, is_answer);
}

void Session::fail(ErrorCode code, std::string sentence) {
    if (closed_) return;
    ++stats_.errors;
    stats_.malformed += code == ErrorCode::Malformed || code == ErrorCode::LimitExceeded;
    stats_.timeouts += code == ErrorCode::Timeout;
    stats_.forbidden += code == ErrorCode::Forbidden;
    answer(write_message(ErrorMessage{code, sentence}));
    if (!is_recoverable(code)) close(std::move(sentence));
}

void Session::close(std::string reason) {
    if (closed_) return;
    closed_ = true;
    actions_.emplace_back(Close{std::move(reason)});
}

void Session::forget_model() {
    model_.reset();
    model_name_.clear();
    schedule_.reset();
    sent_.clear();
    opening_.reset();
    model_wanted_ = index_wanted_ = false;
}

// Token bucket: message_burst at once, messages_per_second in the long run.
bool Session::take_token(Clock::time_point now) {
    const std::chrono::duration<double> elapsed = now - tokens_at_;
    tokens_at_ = now;
    tokens_ = std::min(limits_.message_burst, tokens_ + elapsed.count() * limits_.messages_per_second);
    if (tokens_ < 1) return false;
    tokens_ -= 1;
    return true;
}

Clock::time_point Session::deadline() const {
    if (queued_ > 0) {
        const Clock::time_point stall = last_progress_ + limits_.stall_time;
        return message_begun_ ? std::min(stall, *message_begun_ + limits_.header_time) : stall;
    }
    const Clock::time_point idle = std::max(last_heard_, last_progress_) + limits_.idle_time;
    return message_begun_ ? std::min(idle, *message_begun_ + limits_.header_time) : idle;
}

// Hands out the actions. The timer is only moved when it would fire too late: one that fires early looks again.
Actions Session::flush(Clock::time_point now) {
    now_ = now;
    if (!closed_) {
        const Clock::time_point due = deadline();
        if (!timer_ || due < *timer_) {
            timer_ = due;
            actions_.emplace_back(SetTimer{due});
        }
    }
    return std::exchange(actions_, {});
}

}  // namespace mvw::server
