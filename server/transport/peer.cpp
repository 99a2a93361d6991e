#include "server/transport/peer.h"

#include <fmt/format.h>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>

#include <array>
#include <deque>

#include "server/session.h"
#include "server/transport/waiting.h"

namespace mvw::server {
namespace {

constexpr std::size_t kReadBytes = 2048;            // clients send little
constexpr std::size_t kWriteBytes = 128u << 10;     // gathered for one write
constexpr std::size_t kSendFileBytes = 64u << 10;   // from here on without a copy; below, one write of many is cheaper
constexpr std::uint32_t kFetchBytes = kWriteBytes;  // of a model that is elsewhere, waited for at once
constexpr std::chrono::seconds kLinger{1};          // for the peer to read our last words

/// One connection: three coroutines on one strand (reader, writer, timer) around one session.
class Peer final : public Connection, public std::enable_shared_from_this<Peer> {
 public:
    Peer(std::unique_ptr<Carrier> carrier, Way way, const PeerContext& context, std::string name,
         std::function<void()> on_end)
        : carrier_(std::move(carrier)),
          way_(way),
          timer_(carrier_->strand()),
          wake_(carrier_->strand()),
          context_(context),
          session_(context.open, context.limits, context.allow),
          name_(std::move(name)),
          on_end_(std::move(on_end)) {
        ++context_.metrics.opened[index()];
    }
    ~Peer() override { ++context_.metrics.closed[index()]; }

    Strand strand() override { return carrier_->strand(); }

    void start() override {
        const auto self = shared_from_this();
        asio::co_spawn(
            strand(), [self] { return self->begin(); }, asio::detached);
        asio::co_spawn(
            strand(), [self] { return self->timer_loop(); }, asio::detached);
    }
    void drain() override { perform(session_.on_drain(Clock::now())); }
    void end(const std::string& reason) override {
        if (std::exchange(ended_, true)) return;
        carrier_->close();
        timer_.cancel();
        wake_.cancel();
        count_end();
        log_end(close_reason_.empty() ? reason : close_reason_);
        on_end_();
    }

 private:
    [[nodiscard]] std::size_t index() const { return static_cast<std::size_t>(way_); }

    asio::awaitable<void> begin() {
        set_due(Clock::now() + context_.limits.header_time);
        error_code error;
        co_await carrier_->handshake(error);
        if (error) end("no TLS: " + error.message());
        if (ended_) co_return;
        open_ = true;
        perform(session_.on_start(Clock::now()));
        asio::co_spawn(
            strand(), [self = shared_from_this()] { return self->write_loop(); }, asio::detached);
        co_await read_loop();
    }

    asio::awaitable<void> read_loop() {
        std::array<std::byte, kReadBytes> buffer;
        while (!ended_) {
            error_code error;
            const std::size_t n = co_await carrier_->read(asio::buffer(buffer), error);
            if (ended_) co_return;
            if (error) {
                end(error == asio::error::eof ? "peer left" : error.message());
                co_return;
            }
            perform(session_.on_bytes(ByteSpan(buffer.data(), n), Clock::now()));
        }
    }

    asio::awaitable<void> write_loop() {
        while (!ended_) {
            if (queue_.empty()) {
                if (closing_) {
                    set_due(Clock::now() + kLinger);
                    // Says that no more will come and gives the peer a moment to read it: closing at once could take
                    // our last words back.
                    co_await carrier_->finish();
                    co_return;
                }
                out_ = {};  // an idle peer costs no buffer
                wake_.expires_at(Clock::time_point::max());
                error_code ignored;
                co_await wake_.async_wait(into(ignored));
                continue;
            }
            if (is_far(queue_.front())) {
                const bool fetched = co_await fetch();
                if (!fetched) co_return;
                continue;
            }
            gather();
            const bool written = co_await write_out();
            if (!written) co_return;
            if (queue_.empty() || is_far(queue_.front()) || !goes_as_file(queue_.front())) continue;
            const bool sent_whole = co_await send_file();
            if (!sent_whole) co_return;
        }
    }

    asio::awaitable<bool> write_out() {
        for (std::size_t done = 0; done < out_.size() && !ended_;) {
            error_code error;
            const std::size_t n = co_await carrier_->write(asio::buffer(out_.data() + done, out_.size() - done), error);
            if (!sent(n, error)) co_return false;
            done += n;
        }
        co_return !ended_;
    }

    using Queued = std::variant<Bytes, SendRange>;
    [[nodiscard]] bool goes_as_file(const Queued& queued) const {
        const auto* range = std::get_if<SendRange>(&queued);
        return range != nullptr && range->length >= kSendFileBytes && carrier_->can_send_file() &&
               range->model->descriptor() >= 0;
    }

    // True where the model's source has to be asked for the bytes first.
    [[nodiscard]] static bool is_far(const Queued& queued) {
        const auto* range = std::get_if<SendRange>(&queued);
        return range != nullptr && !range->model->ready(range->offset, std::min(range->length, kFetchBytes));
    }

    // The first bytes of the range at the queue's front.
    asio::awaitable<bool> fetch() {
        const SendRange range = std::get<SendRange>(queue_.front());
        const std::function<void(Fetched)> begin = [range](const Fetched& done) {
            range.model->fetch(range.offset, std::min(range.length, kFetchBytes), done);
        };
        const Result<void> fetched = co_await wait_for<Result<void>>(carrier_->strand(), begin);
        if (!ended_ && !fetched) read_failed(fetched.error());
        co_return !ended_;
    }

    // The range at the queue's front, a part at a time.
    asio::awaitable<bool> send_file() {
        while (!ended_) {
            if (is_far(queue_.front())) co_return true;
            SendRange& range = std::get<SendRange>(queue_.front());
            const std::size_t wanted = std::min<std::size_t>(range.length, kWriteBytes);
            error_code error;
            const std::size_t n = co_await carrier_->send_file(range.model->descriptor(), range.offset, wanted, error);
            if (ended_) co_return false;
            if (!error && n == 0) {
                read_failed({Errc::Io, range.offset, "the file has become shorter"});
                co_return true;
            }
            range.offset += n;
            range.length -= static_cast<std::uint32_t>(n);
            const bool done = range.length == 0;
            if (done) queue_.pop_front();
            if (!sent(n, error)) co_return false;
            if (done) co_return true;
        }
        co_return false;
    }

    bool sent(std::size_t n, const error_code& error) {
        if (ended_) return false;
        if (error) {
            end(error.message());
            return false;
        }
        context_.metrics.bytes_sent[index()] += n;
        perform(session_.on_sent(n, Clock::now()));
        return !ended_;
    }

    void read_failed(const Error& error) {
        queue_.clear();
        perform(session_.on_read_error(error));
    }

    asio::awaitable<void> timer_loop() {
        while (!ended_) {
            timer_.expires_at(due_);
            error_code error;
            co_await timer_.async_wait(into(error));
            if (ended_) co_return;
            if (error || Clock::now() < due_) continue;  // moved
            due_ = Clock::time_point::max();
            if (!open_)
                end("no TLS in time");
            else if (lingering_)
                end("closed");
            else
                perform(session_.on_timer(Clock::now()));
        }
    }

    void perform(Actions actions) {
        for (Action& action : actions) {
            if (auto* bytes = std::get_if<SendBytes>(&action)) {
                queue_.emplace_back(std::move(bytes->bytes));
            } else if (auto* range = std::get_if<SendRange>(&action)) {
                queue_.emplace_back(std::move(*range));
            } else if (const auto* timer = std::get_if<SetTimer>(&action)) {
                set_due(timer->at);
            } else if (const auto* unknown = std::get_if<AwaitModel>(&action)) {
                context_.when_known(unknown->name, [weak = weak_from_this()] {
                    if (const auto self = weak.lock())
                        asio::post(self->strand(), [self] {
                            if (!self->ended_) self->perform(self->session_.on_model_known(Clock::now()));
                        });
                });
            } else {
                closing_ = lingering_ = true;
                close_reason_ = std::get<Close>(action).reason;
                set_due(Clock::now() + context_.limits.stall_time);  // for what is queued to be taken
            }
        }
        if (!queue_.empty() || closing_) wake_.cancel();
    }

    void set_due(Clock::time_point at) {
        due_ = at;
        timer_.cancel();
    }

    // Moves what is queued into out_, up to one write's worth. Files are read here and not earlier.
    void gather() {
        out_.clear();
        while (!queue_.empty() && out_.size() < kWriteBytes && !goes_as_file(queue_.front()) &&
               !is_far(queue_.front())) {
            if (const auto* bytes = std::get_if<Bytes>(&queue_.front())) {
                out_.insert(out_.end(), bytes->begin(), bytes->end());
                queue_.pop_front();
            } else if (!gather_range(std::get<SendRange>(queue_.front()))) {
                return;
            }
        }
    }

    bool gather_range(SendRange& range) {
        const std::size_t at = out_.size();
        const auto n = static_cast<std::uint32_t>(std::min<std::size_t>(range.length, kWriteBytes));
        out_.resize(at + n);
        if (Result<void> r = range.model->read(range.offset, std::span(out_).subspan(at)); !r) {
            out_.resize(at);
            read_failed(r.error());
            return false;
        }
        range.offset += n;
        range.length -= n;
        if (range.length == 0) queue_.pop_front();
        return true;
    }

    void count_end() {
        const SessionStats& s = session_.stats();
        context_.metrics.requests += s.requests;
        context_.metrics.chunks += s.chunks;
        context_.metrics.protocol_errors += s.errors;
        context_.metrics.malformed += s.malformed;
        context_.metrics.timeouts += s.timeouts;
        context_.metrics.forbidden += s.forbidden;
    }

    void log_end(const std::string& reason) const {
        const SessionStats& s = session_.stats();
        context_.log(
            LogLevel::Info,
            fmt::format("event=closed transport={} peer={} model={} requests={} chunks={} bytes={} errors={} reason={}",
                        name_of(way_), name_, log_value(session_.model_name()), s.requests, s.chunks, s.queued_bytes,
                        s.errors, log_value(reason)));
    }

    const std::unique_ptr<Carrier> carrier_;
    const Way way_;
    Timer timer_, wake_;
    const PeerContext& context_;
    Session session_;
    std::string name_;
    std::function<void()> on_end_;
    std::deque<Queued> queue_;
    Bytes out_;
    Clock::time_point due_ = Clock::time_point::max();
    bool open_ = false, closing_ = false, lingering_ = false, ended_ = false;
    std::string close_reason_;
};

}  // namespace

std::shared_ptr<Connection> make_peer(std::unique_ptr<Carrier> carrier, Way way, const PeerContext& context,
                                      std::string name, std::function<void()> on_end) {
    return std::make_shared<Peer>(std::move(carrier), way, context, std::move(name), std::move(on_end));
}

}  // namespace mvw::server
