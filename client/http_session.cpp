#include "client/http_session.h"

#include <algorithm>
#include <utility>

#include "codec/container/crc32c.h"

namespace mvw::client {
namespace {

using protocol::EndReason;

constexpr unsigned kMaxDamage = 3;  // of one chunk; the file on the server is damaged then
constexpr std::uint64_t kMaxFirstBytes = 16u << 20;
constexpr std::uint64_t kBudgetSlack = 4096;  // chunk heads, which budgets do not count
constexpr std::uint64_t kMaxGap = 16u << 10;  // unwanted bytes between two chunks that are cheaper than a request
constexpr std::uint64_t kMaxGroupBytes = 1u << 20;

// Answers that pass by themselves.
bool is_temporary(unsigned status) {
    return status == 408 || status == 429 || status >= 500;
}

std::string refusal(unsigned status) {
    const std::string answer = "the server answers " + std::to_string(status);
    return status == 404 ? answer + ": nothing is there (mvw serve has its models at /models/NAME.mvw)" : answer;
}

}  // namespace

HttpSession::HttpSession(Wants wants, const RetryPolicy& retry, const Limits& limits, std::uint32_t seed)
    : wants_(std::move(wants)), retry_(retry), limits_(limits), backoff_(retry, seed) {}

void HttpSession::restore(Stored stored) {
    Result<FileHeader> header = read_header(stored.header, limits_);
    if (!header) return;
    header_ = std::move(header).value();
    restored_header_ = std::move(stored.header);
    restored_ = std::move(stored.chunks);
    etag_ = std::move(stored.etag);
    walked_ = header_->header_bytes;
    held_bytes_ = header_->header_bytes;
}

HttpActions HttpSession::start(Clock::time_point now) {
    now_ = now;
    if (state_ != State::New) return {};
    if (header_) {
        const std::uint64_t body = header_->index_offset - header_->header_bytes;
        actions_.emplace_back(Opened{std::move(restored_header_), 0, header_->file_bytes(), body});
        for (Received& chunk : restored_) {
            held_.insert(chunk.index);
            held_bytes_ += chunk.payload.size();
            actions_.emplace_back(std::move(chunk));
        }
        restored_ = {};
    }
    plan();
    return flush();
}

HttpActions HttpSession::on_answer(const HttpAnswer& answer, Clock::time_point now) {
    now_ = heard_ = now;
    if (state_ != State::Asking) return {};
    stood_once_ = true;
    if (is_temporary(answer.status)) {
        broken({Errc::Io, 0, refusal(answer.status)}, true);
        return flush();
    }
    const bool is_part = answer.status == 206, is_whole = answer.status == 200;
    if (!is_part && !is_whole && answer.status != 416) {
        fail({Errc::Io, 0, refusal(answer.status)});
        return flush();
    }
    const bool other_tag = !etag_.empty() && answer.etag != etag_;
    // Shorter than it was, or another: what is held and what would come do not belong together.
    if (answer.status == 416 || (header_ && other_tag)) {
        restart();
        return flush();
    }
    if (is_part && answer.first != asked_first_) {
        fail({Errc::Malformed, 0, "the server sends another range than it was asked for"});
        return flush();
    }
    etag_ = answer.etag;
    state_ = State::Reading;
    if (std::exchange(was_broken_, false) && header_) actions_.emplace_back(Resumed{});
    skip_ = 0;
    if (is_whole && (asked_first_ > 0 || needs_index())) {
        ranges_ = false;
        goal_ = Goal::Prefix;
        group_.clear();
        schedule_.reset();
        next_chunk_.reset();
        buffer_.clear();
        at_ = skip_ = walked_;
    }
    return flush();
}

HttpActions HttpSession::on_body(ByteSpan in, Clock::time_point now) {
    now_ = heard_ = now;
    if (state_ != State::Reading) return {};
    if (!wanting_) return {};  // the rest of an answer that has served its end
    const auto skipped = static_cast<std::size_t>(std::min<std::uint64_t>(skip_, in.size()));
    skip_ -= skipped;
    in = in.subspan(skipped);
    buffer_.insert(buffer_.end(), in.begin(), in.end());
    switch (goal_) {
        case Goal::Prefix:
            take_prefix();
            break;
        case Goal::Index:
            take_index();
            break;
        case Goal::Chunks:
            take_chunks();
            break;
    }
    return flush();
}

HttpActions HttpSession::on_body_end(Clock::time_point now) {
    now_ = now;
    if (state_ != State::Reading) return {};
    state_ = State::Asleep;
    if (!wanting_) return flush();
    const bool to_end = goal_ == Goal::Prefix && !ranges_;
    if (!header_) first_bytes_ *= 4;  // a header that is larger than most
    if ((header_ && !useful_) || to_end || first_bytes_ > kMaxFirstBytes)
        broken({Errc::Io, 0, "the answer is shorter than what was asked for"}, false);
    else
        plan();
    return flush();
}

HttpActions HttpSession::on_disconnected(const Error& why, Clock::time_point now) {
    now_ = now;
    if (state_ != State::Asking && state_ != State::Reading) return {};
    if (wanting_)
        broken(why, false);
    else
        state_ = State::Asleep;
    return flush();
}

HttpActions HttpSession::on_timer(Clock::time_point now) {
    now_ = now;
    timer_.reset();
    const std::optional<Clock::time_point> due = deadline();
    if (!due || *due > now) return flush();
    if (state_ == State::Waiting)
        plan();
    else
        broken({Errc::Io, 0, "nothing heard from the server"}, true);
    return flush();
}

HttpActions HttpSession::want(Wants wants, Clock::time_point now) {
    now_ = now;
    if (state_ == State::Ended) return {};
    wants_ = std::move(wants);
    wanting_ = true;
    if (state_ == State::Asking || state_ == State::Reading) abandon();
    if (state_ == State::Asleep) plan();
    return flush();
}

HttpActions HttpSession::cancel(Clock::time_point now) {
    now_ = now;
    if (!wanting_ || state_ == State::Ended) return {};
    if (state_ == State::Asking || state_ == State::Reading) abandon();
    state_ = State::Asleep;
    satisfied(EndReason::Cancelled);
    return flush();
}

// The next request, or the end.
void HttpSession::plan() {
    schedule_.reset();
    next_chunk_.reset();
    group_.clear();
    if (!header_) {
        if (needs_index()) return get(Goal::Prefix, 0, first_bytes_ - 1);
        return get(Goal::Prefix, 0,
                   wants_.byte_budget == 0 ? std::nullopt : std::optional(wants_.byte_budget + kBudgetSlack - 1));
    }
    if (needs_index() && !toc_)
        return get(Goal::Index, header_->index_offset, header_->index_offset + header_->index_bytes - 1);
    if (toc_) {
        schedule_.emplace(*toc_, request());
        return plan_chunks();
    }
    std::uint64_t last = header_->file_bytes() - 1;
    if (wants_.byte_budget != 0) {
        const std::uint64_t room = wants_.byte_budget > held_bytes_ ? wants_.byte_budget - held_bytes_ : 0;
        last = std::min(last, walked_ + room + kBudgetSlack);
    }
    get(Goal::Prefix, walked_, last);
}

void HttpSession::get(Goal goal, std::uint64_t first, std::optional<std::uint64_t> last) {
    goal_ = goal;
    state_ = State::Asking;
    asked_first_ = at_ = first;
    buffer_.clear();
    useful_ = false;
    heard_ = now_;
    actions_.emplace_back(Get{first, last, etag_});
}

// The schedule's next chunks as far as they lie together.
void HttpSession::plan_chunks() {
    const auto next = [&] { return next_chunk_ ? std::exchange(next_chunk_, std::nullopt) : schedule_->next(held_); };
    const auto& chunks = toc_->chunks;
    std::uint64_t end = 0;
    while (const std::optional<std::uint32_t> index = next()) {
        const ChunkEntry& chunk = chunks[*index];
        if (!group_.empty()) {
            bool together = *index > group_.back() && chunk.offset - end <= kMaxGap &&
                            chunk.offset + chunk.length - chunks[group_.front()].offset <= kMaxGroupBytes;
            for (std::uint32_t i = group_.back() + 1; together && i < *index; ++i) together = !held_.contains(i);
            if (!together) {
                next_chunk_ = index;
                break;
            }
        }
        group_.push_back(*index);
        end = chunk.offset + chunk.length;
    }
    if (group_.empty()) return satisfied(schedule_->end_reason());
    const std::uint64_t first = chunks[group_.front()].offset;
    get(Goal::Chunks, first, std::max(end, first + 1) - 1);
}

bool HttpSession::needs_index() const {
    if (!ranges_) return false;
    const bool is_row = held_.empty() || (held_.ranges().size() == 1 && held_.ranges()[0].first == 0 &&
                                          held_.ranges()[0].last + 1 == walked_chunks_);
    return !is_row || wants_.max_level != 255 || wants_.max_layer != 255 || wants_.target_error > 0 ||
           wants_.other_priority != 1 || !wants_.tiles.empty();
}

bool HttpSession::is_wanted(const ChunkId& id) const {
    if (id.channel == Channel::Original || header_->parts[id.part].supersedes)
        return protocol::wants_everything(*header_, request());
    if (leads_to_base(id.channel)) return true;
    if (id.level > wants_.max_level || id.layer > wants_.max_layer) return false;
    if (id.level < header_->parts[id.part].first_tiled_level) return true;
    const auto tile = std::find_if(wants_.tiles.begin(), wants_.tiles.end(),
                                   [&](const auto& t) { return t.part == id.part && t.tile == id.tile; });
    if (tile == wants_.tiles.end()) return wants_.other_priority != 0;
    return tile->priority != 0 && id.level <= tile->max_level;
}

protocol::Request HttpSession::request() const {
    protocol::Request r;
    r.max_level = wants_.max_level;
    r.max_layer = wants_.max_layer;
    r.other_priority = wants_.other_priority;
    r.target_error = wants_.target_error;
    r.byte_budget = wants_.byte_budget;
    r.tiles = wants_.tiles;
    r.held = held_;
    return r;
}

void HttpSession::take_prefix() {
    if (!header_ && !take_header()) return;
    if (walked_ > at_) drop(static_cast<std::size_t>(walked_ - at_));
    while (wanting_ && state_ == State::Reading && take_prefix_chunk()) {
    }
}

bool HttpSession::take_header() {
    Result<FileHeader> header = read_header(buffer_, limits_);
    if (!header) {
        if (header.error().code != Errc::NeedMoreData)
            fail({header.error().code, header.error().offset, "not a .mvw file: " + header.error().message});
        return false;
    }
    header_ = std::move(header).value();
    useful_ = true;
    walked_ = held_bytes_ = header_->header_bytes;
    const Bytes bytes(buffer_.begin(), buffer_.begin() + header_->header_bytes);
    actions_.emplace_back(Opened{bytes, 0, header_->file_bytes(), header_->index_offset - header_->header_bytes});
    return true;
}

// One chunk from the buffer's front; false where it is not all there, or nothing more is to be taken.
bool HttpSession::take_prefix_chunk() {
    if (walked_ >= header_->index_offset) {
        if (take_index()) satisfied(EndReason::Complete);
        return false;
    }
    ByteReader in(buffer_);
    const Result<ChunkHead> head = read_chunk_head(in, walked_id_, limits_);
    if (!head) {
        if (head.error().code != Errc::NeedMoreData) fail(head.error());
        return false;
    }
    if (!check_chunk_id(*header_, head->id)) {
        damaged(walked_chunks_);
        return false;
    }
    const std::size_t head_bytes = in.offset();
    if (walked_ + head_bytes + head->length > header_->index_offset) {
        fail({Errc::Malformed, walked_, "a chunk reaches into the index"});
        return false;
    }
    // Where the walk ends with the first good enough chunk, only the index tells which that is.
    if (needs_index() && wants_.target_error > 0 && head->id.channel != Channel::Base) return false;
    const bool is_held = held_.contains(walked_chunks_), wanted = !is_held && is_wanted(head->id);
    if (wanted && wants_.byte_budget != 0 && held_bytes_ + head->length > wants_.byte_budget) {
        satisfied(EndReason::Budget);
        abandon();
        return false;
    }
    if (buffer_.size() < head_bytes + head->length) return false;
    const ByteSpan payload = ByteSpan(buffer_).subspan(head_bytes, head->length);
    if (chunk_check(ByteSpan(buffer_).first(head_bytes - 2), payload) != head->check) {
        damaged(walked_chunks_);
        return false;
    }
    if (wanted) hand_out(walked_chunks_, head->id, kUnknownError, payload);
    useful_ = true;
    walked_id_ = head->id;
    ++walked_chunks_;
    walked_ += head_bytes + head->length;
    drop(head_bytes + head->length);
    return true;
}

// The index from the buffer's front; false where it is not all there, or not sound.
bool HttpSession::take_index() {
    if (toc_) return true;
    if (buffer_.size() < header_->index_bytes) return false;
    Result<Toc> toc = read_toc(*header_, ByteSpan(buffer_).first(header_->index_bytes), header_->file_bytes(), limits_);
    if (!toc) {
        fail({toc.error().code, toc.error().offset, "the file's index: " + toc.error().message});
        return false;
    }
    toc_ = std::move(toc).value();
    useful_ = true;
    Indexed indexed;
    for (const ChunkEntry& chunk : toc_->chunks) indexed.errors.push_back(chunk.error);
    actions_.emplace_back(std::move(indexed));
    return true;
}

void HttpSession::take_chunks() {
    std::size_t done = 0, taken = 0;
    for (; done < group_.size(); ++done) {
        const ChunkEntry& chunk = toc_->chunks[group_[done]];
        const auto begin = static_cast<std::size_t>(chunk.offset - at_);
        if (buffer_.size() < begin + chunk.length) break;
        const ByteSpan payload = ByteSpan(buffer_).subspan(begin, chunk.length);
        if (crc32c(payload) != chunk.crc32c && damaged(group_[done])) return;
        hand_out(group_[done], chunk.id, chunk.error, payload);
        taken = begin + chunk.length;
    }
    group_.erase(group_.begin(), group_.begin() + static_cast<std::ptrdiff_t>(done));
    drop(taken);
}

void HttpSession::hand_out(std::uint32_t index, const ChunkId& id, float error, ByteSpan payload) {
    held_.insert(index);
    held_bytes_ += payload.size();
    attempts_ = 0;
    useful_ = true;
    actions_.emplace_back(Received{index, id, crc32c(payload), error, Bytes(payload.begin(), payload.end())});
}

bool HttpSession::damaged(std::uint32_t index) {
    const std::string which = "chunk " + std::to_string(index) + " came damaged";
    if (++damaged_[index] >= kMaxDamage)
        fail({Errc::Malformed, 0, which + " each time"});
    else
        broken({Errc::Malformed, 0, which}, true);
    return true;
}

void HttpSession::drop(std::size_t bytes) {
    bytes = std::min(bytes, buffer_.size());
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(bytes));
    at_ += bytes;
}

// Another file has this address now: begin anew.
void HttpSession::restart() {
    if (++restarts_ > retry_.restarts) return fail({Errc::Io, 0, "the model keeps changing on the server"});
    abandon();
    if (header_) actions_.emplace_back(Restarted{});
    header_.reset();
    toc_.reset();
    held_.clear();
    damaged_.clear();
    etag_.clear();
    held_bytes_ = walked_ = 0;
    walked_id_ = {};
    walked_chunks_ = 0;
    was_broken_ = false;
    plan();
}

void HttpSession::broken(Error why, bool answering) {
    if (answering) abandon();
    if (++attempts_ >= (stood_once_ ? retry_.attempts : retry_.first_attempts)) {
        why.message += ", given up after " + std::to_string(attempts_) + " attempts";
        return fail(std::move(why));
    }
    state_ = State::Waiting;
    was_broken_ = true;
    const std::chrono::milliseconds delay = backoff_.delay(attempts_);
    retry_at_ = now_ + delay;
    actions_.emplace_back(Broken{std::move(why), delay});
}

void HttpSession::fail(Error why) {
    abandon();
    state_ = State::Ended;
    actions_.emplace_back(Failed{std::move(why)});
}

void HttpSession::satisfied(EndReason reason) {
    wanting_ = false;
    if (state_ != State::Reading) state_ = State::Asleep;
    actions_.emplace_back(Satisfied{reason});
}

void HttpSession::abandon() {
    if (state_ == State::Asking || state_ == State::Reading) actions_.emplace_back(Abandon{});
    if (state_ != State::Ended) state_ = State::Asleep;
}

std::optional<Clock::time_point> HttpSession::deadline() const {
    if (state_ == State::Waiting) return retry_at_;
    if ((state_ == State::Asking || state_ == State::Reading) && wanting_) return heard_ + retry_.silence_time;
    return std::nullopt;
}

HttpActions HttpSession::flush() {
    return gathered(actions_, timer_, deadline());
}

}  // namespace mvw::client
