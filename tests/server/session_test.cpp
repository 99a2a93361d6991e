#include "server/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "codec/container/crc32c.h"
#include "tests/support/stream_models.h"

namespace mvw::server {
namespace {

using namespace protocol;
using namespace std::chrono_literals;
using test::make_stream_file;
using test::MemoryModel;

/// A session with a peer made of literals: collects what the session sends and reads it as messages.
class SessionTest : public testing::Test {
 protected:
    void start() {
        session_.emplace(
            [this](std::string_view name) -> Result<ModelPtr> {
                if (unknown_) return Error{Errc::NeedMoreData, 0, "not known yet"};
                if (name != "bunny") return Error{Errc::Io, 0, "no such model"};
                return ModelPtr(model_);
            },
            limits_);
        take(session_->on_start(now_));
    }
    void greet() {
        Hello hello;
        hello.max_message_bytes = 1u << 20;
        send(hello);
    }
    template <typename M>
    void send(const M& message) {
        take(session_->on_bytes(write_message(message), now_));
    }
    void open(Request request = {}, const std::string& name = "bunny", const ContentId& content = {}) {
        Open open{name, "", content, std::move(request)};
        send(open);
    }
    // The network takes everything, and again what that sets free.
    void drain_queue() {
        while (session_->queued_bytes() > 0 && !closed_) take(session_->on_sent(session_->queued_bytes(), now_));
    }
    void pass(std::chrono::milliseconds time) {
        now_ += time;
        if (timer_ && *timer_ <= now_) take(session_->on_timer(now_));
    }
    void take(Actions actions) {
        for (Action& action : actions) {
            ASSERT_FALSE(closed_) << "an action after Close";
            if (auto* bytes = std::get_if<SendBytes>(&action)) {
                out_.insert(out_.end(), bytes->bytes.begin(), bytes->bytes.end());
            } else if (auto* range = std::get_if<SendRange>(&action)) {
                Bytes bytes_of_range(range->length);
                ASSERT_TRUE(range->model->read(range->offset, bytes_of_range).ok());
                out_.insert(out_.end(), bytes_of_range.begin(), bytes_of_range.end());
            } else if (auto* timer = std::get_if<SetTimer>(&action)) {
                timer_ = timer->at;
            } else if (const auto* model = std::get_if<AwaitModel>(&action)) {
                awaited_.push_back(model->name);
            } else {
                closed_ = true;
            }
        }
    }
    // Everything sent since the last call, of one kind.
    template <typename M>
    std::vector<M> sent() {
        MessageLimits all;
        all.max_body_bytes = 1u << 30;
        std::vector<M> found;
        for (std::size_t at = 0; at < out_.size();) {
            Result<Parsed> parsed = read_message(ByteSpan(out_).subspan(at), all);
            EXPECT_TRUE(parsed.ok()) << "the session sent something that is no message";
            if (!parsed.ok()) break;
            at += parsed->consumed;
            if (auto* m = std::get_if<M>(&parsed->message)) found.push_back(*m);
        }
        return found;
    }
    std::vector<std::uint32_t> sent_indices() {
        std::vector<std::uint32_t> indices;
        for (const Chunk& c : sent<Chunk>()) indices.push_back(c.index);
        return indices;
    }
    ErrorCode only_error() {
        const auto errors = sent<ErrorMessage>();
        EXPECT_EQ(errors.size(), 1u);
        return errors.empty() ? ErrorCode::Internal : errors[0].code;
    }

    ServerLimits limits_;
    std::shared_ptr<MemoryModel> model_ = MemoryModel::make(make_stream_file());
    std::optional<Session> session_;
    Clock::time_point now_ = Clock::time_point(1h);
    std::optional<Clock::time_point> timer_;
    Bytes out_;
    bool closed_ = false, unknown_ = false;
    std::vector<std::string> awaited_;
};

TEST_F(SessionTest, HelloAndOpenTogetherBringTheWholeModel) {
    start();
    greet();
    open({.id = 5});
    drain_queue();
    EXPECT_EQ(sent<Hello>().size(), 1u);
    const auto models = sent<Model>();
    ASSERT_EQ(models.size(), 1u);
    EXPECT_EQ(models[0].chunk_count, model_->toc().chunks.size());
    EXPECT_EQ(Bytes(models[0].header.begin(), models[0].header.end()),
              Bytes(model_->header().begin(), model_->header().end()));
    const auto chunks = sent<Chunk>();
    ASSERT_EQ(chunks.size(), model_->toc().chunks.size());
    for (std::uint32_t i = 0; i < chunks.size(); ++i) {
        EXPECT_EQ(chunks[i].index, i);
        EXPECT_EQ(chunks[i].id, model_->toc().chunks[i].id);
        EXPECT_EQ(crc32c(chunks[i].payload), chunks[i].crc32c);
    }
    const auto ends = sent<End>();
    ASSERT_EQ(ends.size(), 1u);
    EXPECT_EQ(ends[0],
              (End{5, EndReason::Complete, static_cast<std::uint32_t>(chunks.size()), model_->payload_bytes()}));
    EXPECT_FALSE(closed_);
}

TEST_F(SessionTest, ByteAtATimeIsTheSameConversation) {
    start();
    Hello hello;
    hello.max_message_bytes = 1u << 20;
    Bytes in = write_message(hello);
    const Bytes opening = write_message(Open{"bunny", "", {}, {.id = 5}});
    in.insert(in.end(), opening.begin(), opening.end());
    for (const std::byte b : in) take(session_->on_bytes(ByteSpan(&b, 1), now_));
    drain_queue();
    EXPECT_EQ(sent<Chunk>().size(), model_->toc().chunks.size());
}

TEST_F(SessionTest, HeldSetIsHonoured) {
    Request r;
    for (std::uint32_t i = 0; i < 20; i += 2) r.held.insert(i);
    start();
    greet();
    open(r, "bunny", model_->toc().header.content_id);
    drain_queue();
    const auto indices = sent_indices();
    EXPECT_EQ(indices.size(), model_->toc().chunks.size() - 10);
    for (const std::uint32_t i : indices) EXPECT_FALSE(r.held.contains(i));
}

TEST_F(SessionTest, HeldOfAnotherContentIsChangedAndAnotherOpenMayFollow) {
    Request r;
    r.held.insert(0);
    start();
    greet();
    open(r, "bunny", ContentId{9, 9});
    EXPECT_EQ(only_error(), ErrorCode::Changed);
    EXPECT_TRUE(sent<Chunk>().empty());
    open();
    drain_queue();
    EXPECT_EQ(sent<Chunk>().size(), model_->toc().chunks.size());
}

TEST_F(SessionTest, HeldWithoutContentOrBeyondTheModelIsMalformed) {
    Request r;
    r.held.insert(0);
    start();
    greet();
    open(r);
    EXPECT_EQ(only_error(), ErrorCode::Malformed);
    EXPECT_TRUE(closed_);

    closed_ = false;
    out_.clear();
    r.held.insert(100'000);
    start();
    greet();
    open(r, "bunny", model_->toc().header.content_id);
    EXPECT_EQ(only_error(), ErrorCode::Malformed);
}

TEST_F(SessionTest, NewRequestReplacesTheOldOneAndNothingIsSentTwice) {
    limits_.soft_queue_bytes = 2000;
    start();
    greet();
    open({.id = 1});
    const std::size_t before = sent_indices().size();
    ASSERT_LT(before, 20u);
    Request second{.id = 2, .other_priority = 1};
    second.tiles = {{0, 3, 9, 255}};
    send(second);
    drain_queue();
    const auto indices = sent_indices();
    EXPECT_EQ(std::set<std::uint32_t>(indices.begin(), indices.end()).size(), indices.size());
    EXPECT_EQ(indices.size(), model_->toc().chunks.size());
    const std::size_t of_tile_3 =
        static_cast<std::size_t>(std::count_if(indices.begin(), indices.begin() + static_cast<std::ptrdiff_t>(before),
                                               [&](std::uint32_t i) { return model_->toc().chunks[i].id.tile == 3; }));
    for (std::size_t i = before; i < before + 16 - of_tile_3; ++i)
        EXPECT_EQ(model_->toc().chunks[indices[i]].id.tile, 3) << "the tile that is wanted first did not come first";
    const auto ends = sent<End>();
    ASSERT_EQ(ends.size(), 1u);
    EXPECT_EQ(ends[0].id, 2u);
}

TEST_F(SessionTest, CancelEndsTheRequestAndOldCancelsDoNothing) {
    limits_.soft_queue_bytes = 2000;
    start();
    greet();
    open({.id = 1});
    const std::size_t before = sent_indices().size();
    send(Cancel{99});
    EXPECT_TRUE(sent<End>().empty());
    send(Cancel{1});
    drain_queue();
    EXPECT_EQ(sent_indices().size(), before);
    const auto ends = sent<End>();
    ASSERT_EQ(ends.size(), 1u);
    EXPECT_EQ(ends[0].reason, EndReason::Cancelled);
    EXPECT_EQ(ends[0].chunks, before);
    send(Cancel{1});
    EXPECT_EQ(sent<End>().size(), 1u);
}

TEST_F(SessionTest, IndexComesAsItIsOnDisk) {
    start();
    greet();
    open({.byte_budget = 1});
    send(GetIndex{});
    drain_queue();
    const auto index = sent<Index>();
    ASSERT_EQ(index.size(), 1u);
    const Result<Toc> toc = read_toc(model_->toc().header, index[0].bytes, model_->file_bytes());
    ASSERT_TRUE(toc.ok());
    EXPECT_EQ(toc->chunks.size(), model_->toc().chunks.size());
}

TEST_F(SessionTest, ModelThatIsBeingLookedUpIsAwaitedAndWhatIsAskedMeanwhileCounts) {
    unknown_ = true;
    start();
    greet();
    open({.id = 1});
    send(Request{.id = 2, .max_level = 0});
    send(GetIndex{});
    send(Ping{5});
    EXPECT_EQ(awaited_, std::vector<std::string>{"bunny"});
    EXPECT_EQ(sent<Pong>().size(), 1u);
    take(session_->on_model_known(now_));
    EXPECT_EQ(awaited_.size(), 2u) << "not known even now: waits on";
    unknown_ = false;
    take(session_->on_model_known(now_));
    drain_queue();
    EXPECT_EQ(sent<Model>().size(), 1u);
    EXPECT_EQ(sent<Index>().size(), 1u);
    for (const Chunk& c : sent<Chunk>()) EXPECT_EQ(c.id.level, 0);
    ASSERT_EQ(sent<End>().size(), 1u);
    EXPECT_EQ(sent<End>()[0].id, 2u);
    take(session_->on_model_known(now_));
    EXPECT_EQ(sent<Model>().size(), 1u);
}

TEST_F(SessionTest, AwaitedModelMayTurnOutToBeNoneOrBeCancelledOrDrained) {
    unknown_ = true;
    start();
    greet();
    open({.id = 1}, "nobody");
    open({.id = 2}, "nobody");
    unknown_ = false;
    take(session_->on_model_known(now_));
    take(session_->on_model_known(now_));
    EXPECT_EQ(only_error(), ErrorCode::NotFound);
    unknown_ = true;
    open({.id = 3});
    send(Cancel{3});
    ASSERT_EQ(sent<End>().size(), 1u);
    EXPECT_EQ(sent<End>()[0].reason, EndReason::Cancelled);
    open({.id = 4});
    take(session_->on_drain(now_));
    EXPECT_FALSE(closed_) << "a request is present";
    unknown_ = false;
    take(session_->on_model_known(now_));
    drain_queue();
    EXPECT_EQ(sent<End>().size(), 2u);
    EXPECT_TRUE(closed_);
}

TEST_F(SessionTest, PingIsAnsweredWithItsNonce) {
    start();
    greet();
    send(Ping{77});
    const auto pongs = sent<Pong>();
    ASSERT_EQ(pongs.size(), 1u);
    EXPECT_EQ(pongs[0].nonce, 77u);
}

TEST_F(SessionTest, UnknownModelIsNotFoundAndAnotherOpenMayFollow) {
    start();
    greet();
    open({}, "../secret");
    EXPECT_EQ(only_error(), ErrorCode::NotFound);
    send(Request{});
    send(GetIndex{});
    EXPECT_EQ(sent<ErrorMessage>().size(), 3u);
    EXPECT_FALSE(closed_);
    open();
    drain_queue();
    EXPECT_FALSE(sent<Chunk>().empty());
}

TEST_F(SessionTest, OnlyHelloMayComeFirstAndOnlyOnce) {
    start();
    send(Ping{});
    EXPECT_EQ(only_error(), ErrorCode::Malformed);
    EXPECT_TRUE(closed_);

    closed_ = false;
    out_.clear();
    start();
    greet();
    greet();
    EXPECT_EQ(only_error(), ErrorCode::Malformed);
}

TEST_F(SessionTest, OtherVersionsAndUnknownFeaturesAreUnsupported) {
    for (const Hello& hello : {Hello{2, 2, 0, 1 << 20, 0}, Hello{0, 0, 0, 1 << 20, 0}, Hello{1, 1, 4, 1 << 20, 0}}) {
        closed_ = false;
        out_.clear();
        start();
        send(hello);
        EXPECT_EQ(only_error(), ErrorCode::Unsupported);
        EXPECT_TRUE(closed_);
    }
    closed_ = false;
    out_.clear();
    start();
    send(Hello{7, 1, 0, 1 << 20, 0});
    EXPECT_EQ(sent<Hello>().at(0).version, kVersion) << "a newer client that can go back is welcome";
}

TEST_F(SessionTest, MessagesOfServersAreMalformedFromAClient) {
    start();
    greet();
    send(End{});
    EXPECT_EQ(only_error(), ErrorCode::Malformed);
    EXPECT_TRUE(closed_);
}

TEST_F(SessionTest, OversizedMessageIsRefusedByItsHead) {
    start();
    greet();
    const Bytes head{std::byte{0xFF}, std::byte{0xFF}, std::byte{0xFF}, std::byte{0x7F}, std::byte{2}};
    take(session_->on_bytes(head, now_));
    EXPECT_EQ(only_error(), ErrorCode::LimitExceeded);
    EXPECT_TRUE(closed_);
}

TEST_F(SessionTest, SlowReaderIsPausedThenClosed) {
    limits_.soft_queue_bytes = 2000;
    start();
    greet();
    open();
    const std::size_t queued = session_->queued_bytes();
    EXPECT_LT(queued, 2000u + 500u) << "paused at the soft limit";
    pass(limits_.stall_time / 2);
    EXPECT_FALSE(closed_);
    take(session_->on_sent(1000, now_));  // it reads after all
    EXPECT_GT(sent_indices().size(), 4u);
    pass(limits_.stall_time - 1ms);
    EXPECT_FALSE(closed_);
    pass(2ms);
    EXPECT_TRUE(closed_);
}

TEST_F(SessionTest, AskingWithoutReadingMeetsTheHardLimit) {
    limits_.hard_queue_bytes = 100;
    start();
    greet();
    for (int i = 0; i < 20 && !closed_; ++i) send(Ping{});
    EXPECT_TRUE(closed_);
    EXPECT_LT(session_->queued_bytes(), 150u);
}

TEST_F(SessionTest, HelloIsDueInTimeAndEveryMessageOnceBegun) {
    start();
    pass(limits_.header_time + 1ms);
    EXPECT_EQ(only_error(), ErrorCode::Timeout);
    EXPECT_TRUE(closed_);

    closed_ = false;
    out_.clear();
    timer_.reset();
    start();
    greet();
    drain_queue();
    const std::byte one{1};
    for (int i = 0; i < 3; ++i) {  // a byte now and then does not help
        take(session_->on_bytes(ByteSpan(&one, i == 0 ? 1 : 0), now_));
        pass(limits_.header_time / 2);
    }
    EXPECT_TRUE(closed_);
    EXPECT_EQ(only_error(), ErrorCode::Timeout);
}

TEST_F(SessionTest, IdlePeerIsClosedAndAPingKeepsItOpen) {
    start();
    greet();
    open();
    drain_queue();
    for (int i = 0; i < 4; ++i) {
        pass(limits_.idle_time - 1s);
        EXPECT_FALSE(closed_);
        send(Ping{});
        drain_queue();
    }
    pass(limits_.idle_time + 1s);
    EXPECT_TRUE(closed_);
    EXPECT_EQ(only_error(), ErrorCode::Timeout);
}

TEST_F(SessionTest, TooManyMessagesASecondEndTheConnection) {
    limits_.message_burst = 10;
    start();
    greet();
    for (int i = 0; i < 30 && !closed_; ++i) send(Ping{});
    EXPECT_TRUE(closed_);
    EXPECT_EQ(only_error(), ErrorCode::TooBusy);
}

TEST_F(SessionTest, FileOverwrittenInMidStreamIsChangedAndNotMixed) {
    limits_.soft_queue_bytes = 2000;
    start();
    greet();
    open();
    const std::size_t before = sent_indices().size();
    model_->intact_ = false;
    drain_queue();
    EXPECT_EQ(only_error(), ErrorCode::Changed);
    EXPECT_EQ(sent_indices().size(), before);
    EXPECT_FALSE(closed_);
}

TEST_F(SessionTest, UnreadableFileClosesTheConnection) {
    start();
    greet();
    open();
    take(session_->on_read_error({Errc::Io, 0, "disk"}));
    EXPECT_TRUE(closed_);
    EXPECT_TRUE(session_->on_bytes(write_message(Ping{}), now_).empty());
}

TEST_F(SessionTest, ChunkLargerThanThePeerAcceptsIsAnErrorBeforeItIsSent) {
    start();
    send(Hello{1, 1, 0, 250, 0});
    open();
    drain_queue();
    EXPECT_EQ(only_error(), ErrorCode::LimitExceeded);
    EXPECT_TRUE(closed_);
    for (const Chunk& c : sent<Chunk>()) EXPECT_LE(c.payload.size() + kChunkFieldBytes, 250u);
}

TEST_F(SessionTest, DrainingFinishesTheRequestAndClosesTheIdleAtOnce) {
    limits_.soft_queue_bytes = 2000;
    start();
    greet();
    open();
    take(session_->on_drain(now_));
    EXPECT_FALSE(closed_);
    drain_queue();
    EXPECT_TRUE(closed_);
    EXPECT_EQ(sent_indices().size(), model_->toc().chunks.size());
    EXPECT_EQ(only_error(), ErrorCode::ShuttingDown);

    closed_ = false;
    out_.clear();
    start();
    greet();
    take(session_->on_drain(now_));
    EXPECT_TRUE(closed_);
    EXPECT_EQ(only_error(), ErrorCode::ShuttingDown);
}

TEST_F(SessionTest, RandomBytesNeverGetMoreThanAnError) {
    std::mt19937 random(11);
    for (int round = 0; round < 2000; ++round) {
        closed_ = false;
        out_.clear();
        start();
        if (round % 2 == 0) greet();
        Bytes noise(random() % 200);
        for (std::byte& b : noise) b = static_cast<std::byte>(random() % (round % 3 == 0 ? 13 : 256));
        take(session_->on_bytes(noise, now_));
        EXPECT_TRUE(sent<Chunk>().empty());
    }
}

}  // namespace
}  // namespace mvw::server
