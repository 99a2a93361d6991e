// The HTTP session against servers of a few lines: with Range, without it, cut, changed, refusing.
#include "client/http_session.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "codec/mesh/io/files.h"
#include "tests/support/program.h"
#include "tests/support/stream_models.h"

namespace mvw::client {
namespace {

using namespace std::chrono_literals;
using protocol::EndReason;
using test::make_stream_file;

/// Answers Gets from a file, and books what was sent and what was told.
class Server {
 public:
    explicit Server(Bytes file, std::string etag = "\"1\"") : file_(std::move(file)), etag_(std::move(etag)) {}

    void run(HttpSession& session, HttpActions actions) {
        while (true) {
            take(std::move(actions));
            if (get_) {
                const Get get = *std::exchange(get_, std::nullopt);
                actions = answer(session, get);
            } else if (timer_ && !ended()) {
                now_ = std::max(now_, *std::exchange(timer_, std::nullopt));
                actions = session.on_timer(now_);
            } else {
                return;
            }
        }
    }
    [[nodiscard]] bool ended() const { return satisfied || failed; }

    std::vector<Received> received;
    std::optional<EndReason> satisfied;
    std::optional<Error> failed;
    std::vector<float> errors;
    int gets = 0, restarted = 0, resumed = 0, opened = 0;
    std::uint64_t body_bytes = 0;
    bool ranges = true;
    std::size_t slice = 700;                 // of a body
    std::uint64_t break_after = UINT64_MAX;  // bytes of one answer's body, once
    std::function<void()> on_break;
    unsigned status = 0;  // of all answers, unless 0
    Bytes file_;
    std::string etag_;
    Clock::time_point now_{};

 private:
    void take(HttpActions actions) {
        for (HttpAction& action : actions) {
            if (const auto* get = std::get_if<Get>(&action))
                get_ = *get;
            else if (std::holds_alternative<Abandon>(action))
                get_.reset(), abandoned_ = true;
            else if (const auto* timer = std::get_if<SetTimer>(&action))
                timer_ = timer->at;
            else if (auto* chunk = std::get_if<Received>(&action))
                received.push_back(std::move(*chunk));
            else if (auto* indexed = std::get_if<Indexed>(&action))
                errors = std::move(indexed->errors);
            else if (const auto* s = std::get_if<Satisfied>(&action))
                satisfied = s->reason;
            else if (const auto* f = std::get_if<Failed>(&action))
                failed = f->why;
            else if (std::holds_alternative<Restarted>(action))
                ++restarted, received.clear();
            else if (std::holds_alternative<Resumed>(action))
                ++resumed;
            else if (std::holds_alternative<Opened>(action))
                ++opened;
        }
    }

    HttpActions answer(HttpSession& session, const Get& get) {
        ++gets;
        abandoned_ = false;
        const bool asked = get.first > 0 || get.last;
        const bool part = ranges && asked && (get.if_range.empty() || get.if_range == etag_);
        HttpAnswer head{part ? 206u : 200u, etag_, part ? get.first : 0};
        if (part && get.first >= file_.size()) head.status = 416;
        if (status != 0) head.status = status;
        take(session.on_answer(head, now_));
        const std::uint64_t end =
            part && get.last ? std::min<std::uint64_t>(*get.last + 1, file_.size()) : file_.size();
        std::uint64_t sent = 0;
        for (std::uint64_t at = head.first; at < end && !abandoned_ && head.status < 300;) {
            const std::uint64_t n = std::min<std::uint64_t>(slice, end - at);
            take(session.on_body(ByteSpan(file_).subspan(at, n), now_));
            at += n;
            sent += n;
            body_bytes += n;
            if (sent >= break_after) {
                break_after = UINT64_MAX;
                if (on_break) on_break();
                return session.on_disconnected({Errc::Io, 0, "cut"}, now_);
            }
        }
        if (abandoned_ || head.status >= 300) return {};
        return session.on_body_end(now_);
    }

    std::optional<Get> get_;
    std::optional<Clock::time_point> timer_;
    bool abandoned_ = false;
};

const test::StreamModelShape kShape{.tiles = 4, .levels = 3, .layers = 4, .payload_bytes = 2000};

void expect_chunks(const Server& server, const std::set<std::uint32_t>& wanted) {
    const auto model = test::MemoryModel::make(server.file_);
    std::set<std::uint32_t> got;
    for (const Received& r : server.received) {
        EXPECT_TRUE(got.insert(r.index).second) << "chunk " << r.index << " twice";
        const ChunkEntry& chunk = model->toc().chunks[r.index];
        Bytes expected(chunk.length);
        ASSERT_TRUE(model->read(chunk.offset, expected).ok());
        EXPECT_EQ(r.payload, expected);
        EXPECT_EQ(r.id, chunk.id);
        EXPECT_EQ(r.crc32c, chunk.crc32c);
    }
    EXPECT_EQ(got, wanted);
}

std::set<std::uint32_t> all_of(const Bytes& file, const std::function<bool(const ChunkEntry&)>& wanted) {
    std::set<std::uint32_t> indices;
    const auto model = test::MemoryModel::make(file);
    for (std::uint32_t i = 0; i < model->toc().chunks.size(); ++i)
        if (wanted(model->toc().chunks[i])) indices.insert(i);
    return indices;
}
const auto kAll = [](const ChunkEntry&) { return true; };

TEST(HttpSession, WholeModelIsOneRequestAndNoByteTwice) {
    Server server(make_stream_file(kShape));
    HttpSession session({});
    server.run(session, session.start(server.now_));
    EXPECT_EQ(server.satisfied, EndReason::Complete);
    expect_chunks(server, all_of(server.file_, kAll));
    EXPECT_EQ(server.gets, 1);
    EXPECT_EQ(server.body_bytes, server.file_.size());
    EXPECT_EQ(server.errors.size(), server.received.size()) << "the index tells the errors";
}

TEST(HttpSession, BrokenAnswerIsResumedWhereItsLastWholeChunkEnded) {
    const Bytes file = make_stream_file(kShape);
    for (std::uint64_t cut : {100u, 5'000u, 40'000u, 90'000u}) {
        Server server(file);
        server.break_after = cut;
        HttpSession session({});
        server.run(session, session.start(server.now_));
        EXPECT_EQ(server.satisfied, EndReason::Complete);
        expect_chunks(server, all_of(file, kAll));
        EXPECT_EQ(server.gets, 2);
        EXPECT_LE(server.body_bytes, file.size() + 4'000) << "more than the chunk that was cut came again";
    }
}

TEST(HttpSession, EveryCutOfEveryAnswerEndsWithTheWholeModel) {
    const Bytes file = make_stream_file({.tiles = 2, .levels = 1, .layers = 2, .payload_bytes = 60});
    for (std::uint64_t cut = 1; cut <= file.size(); ++cut) {
        Server server(file);
        server.slice = 1;
        server.break_after = cut;
        HttpSession session({});
        server.run(session, session.start(server.now_));
        ASSERT_EQ(server.satisfied, EndReason::Complete) << cut;
        expect_chunks(server, all_of(file, kAll));
    }
}

TEST(HttpSession, LevelsAndErrorsComeByIndexAndRange) {
    Server server(make_stream_file(kShape));
    Wants wants;
    wants.max_level = 1;
    HttpSession session(wants);
    server.run(session, session.start(server.now_));
    EXPECT_EQ(server.satisfied, EndReason::Complete);
    expect_chunks(server, all_of(server.file_, [](const ChunkEntry& c) { return c.id.level <= 1; }));
    EXPECT_LT(server.body_bytes, server.file_.size());

    Server exact(server.file_);
    const auto model = test::MemoryModel::make(server.file_);
    wants = {};
    wants.target_error = model->toc().chunks[10].error;
    HttpSession second(wants);
    exact.run(second, second.start(exact.now_));
    expect_chunks(exact, all_of(server.file_, [&](const ChunkEntry& c) { return c.error >= wants.target_error; }));
}

TEST(HttpSession, SplitsComeToEveryView) {
    Server server(read_file(test_data_folder() + "/golden_plain.mvw").value());
    Wants wants;  // a part of the surface, and nothing else
    wants.tiles = {{0, 0, 9, 3}};
    wants.other_priority = 0;
    wants.max_layer = 1;
    HttpSession session(wants);
    server.run(session, session.start(server.now_));
    const std::set<std::uint32_t> expected = all_of(server.file_, [](const ChunkEntry& c) {
        return c.id.channel != Channel::Geometry || (c.id.tile == 0 && c.id.layer <= 1);
    });
    EXPECT_GT(expected.size(), 3u);
    expect_chunks(server, expected);
}

TEST(HttpSession, BudgetIsNotGoneOver) {
    Server server(make_stream_file(kShape));
    Wants wants;
    wants.byte_budget = 30'000;
    HttpSession session(wants);
    server.run(session, session.start(server.now_));
    EXPECT_EQ(server.satisfied, EndReason::Budget);
    std::uint64_t held = read_header(server.file_).value().header_bytes;
    for (const Received& r : server.received) held += r.payload.size();
    EXPECT_LE(held, wants.byte_budget);
    EXPECT_GT(held, wants.byte_budget - 4'000);
    EXPECT_LE(server.body_bytes, wants.byte_budget + 5'000);
}

TEST(HttpSession, WantsMoreLaterWithoutAChunkTwice) {
    Server server(make_stream_file(kShape));
    Wants wants;
    wants.max_level = 1;
    HttpSession session(wants);
    server.run(session, session.start(server.now_));
    server.satisfied.reset();
    server.run(session, session.want({}, server.now_));
    EXPECT_EQ(server.satisfied, EndReason::Complete);
    expect_chunks(server, all_of(server.file_, kAll));
}

TEST(HttpSession, ServerWithoutRangesServesWholeAndFiltered) {
    for (const std::uint8_t level : {255, 1}) {
        Server server(make_stream_file(kShape), "");
        server.ranges = false;
        server.break_after = 50'000;
        Wants wants;
        wants.max_level = level;
        HttpSession session(wants);
        server.run(session, session.start(server.now_));
        EXPECT_EQ(server.satisfied, EndReason::Complete);
        expect_chunks(server, all_of(server.file_, [&](const ChunkEntry& c) { return c.id.level <= level; }));
    }
}

TEST(HttpSession, FileThatChangesIsBegunAnewAndNeverMixed) {
    const Bytes fresh = make_stream_file({.tiles = 4, .levels = 2, .layers = 4, .payload_bytes = 1500, .seed = 9});
    for (const bool ranges : {true, false}) {
        Server server(make_stream_file(kShape));
        server.ranges = ranges;
        server.break_after = 20'000;
        server.on_break = [&] {
            server.file_ = fresh;
            server.etag_ = "\"2\"";
        };
        HttpSession session({});
        server.run(session, session.start(server.now_));
        EXPECT_EQ(server.restarted, 1);
        EXPECT_EQ(server.satisfied, EndReason::Complete);
        expect_chunks(server, all_of(fresh, kAll));
    }
}

TEST(HttpSession, WhatWasStoredIsNotAskedFor) {
    Server server(make_stream_file(kShape));
    HttpSession first({});
    server.run(first, first.start(server.now_));
    Stored stored{.header =
                      Bytes(server.file_.begin(), server.file_.begin() + read_header(server.file_)->header_bytes)};
    stored.etag = server.etag_;
    for (std::size_t i = 0; i < server.received.size(); ++i)
        if (i % 3 != 1) stored.chunks.push_back(server.received[i]);
    std::uint64_t missing = 0;
    for (std::size_t i = 1; i < server.received.size(); i += 3) missing += server.received[i].payload.size();
    Server again(server.file_);
    HttpSession session({});
    session.restore(std::move(stored));
    again.run(session, session.start(again.now_));
    EXPECT_EQ(again.satisfied, EndReason::Complete);
    expect_chunks(again, all_of(server.file_, kAll));
    EXPECT_EQ(again.body_bytes, missing + read_header(server.file_)->index_bytes);
}

TEST(HttpSession, DamagedChunkIsAskedForAgainAndThenAFault) {
    Server server(make_stream_file(kShape));
    server.file_[server.file_.size() / 2] ^= std::byte{1};
    HttpSession session({});
    server.run(session, session.start(server.now_));
    ASSERT_TRUE(server.failed);
    EXPECT_NE(server.failed->message.find("damaged each time"), std::string::npos) << server.failed->message;
}

TEST(HttpSession, RefusalsAreFinalAndBusyServersAreTriedAgain) {
    for (const unsigned status : {404u, 403u, 301u, 204u}) {
        Server server(make_stream_file());
        server.status = status;
        HttpSession session({});
        server.run(session, session.start(server.now_));
        ASSERT_TRUE(server.failed) << status;
        EXPECT_EQ(server.gets, 1);
        EXPECT_NE(server.failed->message.find(std::to_string(status)), std::string::npos);
        EXPECT_EQ(server.failed->message.find("/models/") != std::string::npos, status == 404);
    }
    Server busy(make_stream_file());
    busy.status = 503;
    HttpSession session({});
    busy.run(session, session.start(busy.now_));
    EXPECT_TRUE(busy.failed);
    EXPECT_EQ(busy.gets, static_cast<int>(RetryPolicy{}.attempts));
}

TEST(HttpSession, AnyBytesAreAnAnswerAndEndWithAWord) {
    unsigned random = 1;
    for (int round = 0; round < 300; ++round) {
        Bytes file = make_stream_file({.tiles = 2, .levels = 1, .layers = 2, .payload_bytes = 60});
        for (int i = 0; i < 4; ++i) {
            random = random * 1664525u + 1013904223u;
            file[random % file.size()] = static_cast<std::byte>(random >> 24);
        }
        Server server(file);
        Wants wants;
        if (round % 2 == 1) wants.max_level = 0;
        HttpSession session(wants);
        server.run(session, session.start(server.now_));
        EXPECT_TRUE(server.ended());
    }
}

}  // namespace
}  // namespace mvw::client
