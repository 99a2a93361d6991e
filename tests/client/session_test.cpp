#include "client/session.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "codec/container/toc.h"
#include "server/session.h"
#include "tests/support/stream_models.h"

namespace mvw::client {
namespace {

using namespace std::chrono_literals;
using protocol::EndReason;
using test::make_stream_file;
using test::MemoryModel;

/// A client and a server session joined without a network, in made-up time. Every hand-over of bytes counts as a call
/// of the transport; the call `fail_at` breaks the connection, and with it what was under way.
class Loopback {
 public:
    explicit Loopback(Wants wants = {}, const RetryPolicy& retry = {})
        : client("bunny", "", std::move(wants), retry, {}, 7) {
        limits.soft_queue_bytes = 2000;
        limits.message_burst = 1e9;
    }

    void run() {
        perform(client.start(now));
        settle();
    }
    // Until nothing moves any more; then time leaps to the next timer, while something is due.
    void settle() {
        for (int idle = 0; idle < 200 && !done();) {
            if (step()) {
                idle = 0;
                continue;
            }
            ++idle;
            now = std::max(now, timer.value_or(now));
            if (timer) perform(client.on_timer(now));
        }
    }
    [[nodiscard]] bool done() const { return satisfied.has_value() || failed.has_value(); }

    // Hands over one slice, in either direction.
    bool step() {
        if (connecting) {
            connecting = false;
            if (!server_up || call_fails()) {
                perform(client.on_disconnected({Errc::Io, 0, "refused"}, now));
                return true;
            }
            server.emplace([this](std::string_view) -> Result<server::ModelPtr> { return server::ModelPtr(model); },
                           limits);
            to_client.clear();
            to_server.clear();
            perform_server(server->on_start(now));
            perform(client.on_connected(now));
            return true;
        }
        if (!server) return false;
        if (!to_server.empty()) {
            if (call_fails()) return cut(), true;
            const Bytes bytes = std::exchange(to_server, {});
            perform_server(server->on_bytes(bytes, now));
            return true;
        }
        if (!to_client.empty()) {
            if (call_fails()) return cut(), true;
            const std::size_t n = std::min<std::size_t>(to_client.size(), 700);
            const Bytes bytes(to_client.begin(), to_client.begin() + static_cast<std::ptrdiff_t>(n));
            to_client.erase(to_client.begin(), to_client.begin() + static_cast<std::ptrdiff_t>(n));
            if (server) perform_server(server->on_sent(n, now));
            perform(client.on_bytes(bytes, now));
            return true;
        }
        if (server_closed) return cut(), true;
        return false;
    }

    void cut() {
        server.reset();
        server_closed = false;
        perform(client.on_disconnected({Errc::Io, 0, "cut"}, now));
    }
    bool call_fails() { return calls++ == fail_at || (fail_every != 0 && calls % fail_every == 0); }

    void perform(Actions actions) {
        for (Action& action : actions) {
            if (std::holds_alternative<Connect>(action)) {
                connecting = true;
                server.reset();
                server_closed = false;
            } else if (auto* bytes = std::get_if<SendBytes>(&action)) {
                to_server.insert(to_server.end(), bytes->bytes.begin(), bytes->bytes.end());
            } else if (auto* t = std::get_if<SetTimer>(&action)) {
                timer = t->at;
            } else if (std::holds_alternative<Disconnect>(action)) {
                server.reset();
                connecting = false;
            } else if (auto* chunk = std::get_if<Received>(&action)) {
                received.push_back(std::move(*chunk));
            } else if (std::holds_alternative<Opened>(action)) {
                ++opened;
            } else if (auto* s = std::get_if<Satisfied>(&action)) {
                satisfied = s->reason;
            } else if (std::holds_alternative<Broken>(action)) {
                ++broken;
            } else if (std::holds_alternative<Resumed>(action)) {
                ++resumed;
            } else if (std::holds_alternative<Restarted>(action)) {
                ++restarted;
                received.clear();
            } else if (auto* f = std::get_if<Failed>(&action)) {
                failed = f->why;
            }
        }
    }
    void perform_server(server::Actions actions) {
        for (server::Action& action : actions) {
            if (auto* bytes = std::get_if<server::SendBytes>(&action)) {
                to_client.insert(to_client.end(), bytes->bytes.begin(), bytes->bytes.end());
            } else if (auto* range = std::get_if<server::SendRange>(&action)) {
                Bytes b(range->length);
                ASSERT_TRUE(range->model->read(range->offset, b).ok());
                if (damage_offset == range->offset && damage_times-- > 0) b[0] ^= std::byte{1};
                to_client.insert(to_client.end(), b.begin(), b.end());
            } else if (std::holds_alternative<server::Close>(action)) {
                server_closed = true;
            }
        }
    }

    // Every chunk of the model once, with its bytes.
    void expect_all_received_once() const {
        std::set<std::uint32_t> indices;
        for (const Received& r : received) {
            EXPECT_TRUE(indices.insert(r.index).second) << "chunk " << r.index << " came twice";
            Bytes expected(model->toc().chunks[r.index].length);
            ASSERT_TRUE(model->read(model->toc().chunks[r.index].offset, expected).ok());
            EXPECT_EQ(r.payload, expected);
        }
        EXPECT_EQ(indices.size(), model->toc().chunks.size());
    }

    server::ServerLimits limits;
    std::shared_ptr<MemoryModel> model = MemoryModel::make(make_stream_file());
    Session client;
    std::optional<server::Session> server;
    Clock::time_point now = Clock::time_point(1h);
    std::optional<Clock::time_point> timer;
    Bytes to_client, to_server;
    bool connecting = false, server_up = true, server_closed = false;
    std::size_t calls = 0, fail_at = SIZE_MAX, fail_every = 0;
    std::uint64_t damage_offset = 0;
    int damage_times = 0;

    std::vector<Received> received;
    std::optional<EndReason> satisfied;
    std::optional<Error> failed;
    int opened = 0, broken = 0, resumed = 0, restarted = 0;
};

TEST(ClientSession, GetsTheWholeModel) {
    Loopback loop;
    loop.run();
    EXPECT_EQ(loop.satisfied, EndReason::Complete);
    EXPECT_EQ(loop.opened, 1);
    loop.expect_all_received_once();
}

TEST(ClientSession, AsksInTheFirstFlight) {
    Session session("bunny", "", {});
    const Clock::time_point now{};
    ASSERT_TRUE(std::holds_alternative<Connect>(session.start(now).at(0)));
    Bytes flight;
    for (const Action& a : session.on_connected(now))
        if (const auto* b = std::get_if<SendBytes>(&a)) flight.insert(flight.end(), b->bytes.begin(), b->bytes.end());
    protocol::MessageStream stream{protocol::MessageLimits{}};
    stream.add(flight);
    EXPECT_TRUE(std::holds_alternative<protocol::Hello>(stream.next().value()));
    EXPECT_TRUE(std::holds_alternative<protocol::Open>(stream.next().value()));
}

TEST(ClientSession, SurvivesFailureOfEveryCall) {
    Loopback smooth;
    smooth.run();
    ASSERT_GT(smooth.calls, 20u);
    for (std::size_t n = 0; n < smooth.calls; ++n) {
        Loopback loop;
        loop.fail_at = n;
        loop.run();
        ASSERT_EQ(loop.satisfied, EndReason::Complete) << "call " << n;
        EXPECT_EQ(loop.broken, 1);
        EXPECT_EQ(loop.opened, 1);
        loop.expect_all_received_once();
    }
}

TEST(ClientSession, GetsThereOverAConnectionThatKeepsBreaking) {
    Loopback loop;
    loop.fail_every = 9;
    loop.run();
    EXPECT_EQ(loop.satisfied, EndReason::Complete);
    EXPECT_GT(loop.resumed, 3);
    loop.expect_all_received_once();
}

TEST(ClientSession, GivesUpAfterSoManyAttemptsWithGrowingDelays) {
    RetryPolicy retry;
    retry.first_attempts = 5;
    Loopback loop({}, retry);
    loop.server_up = false;
    const Clock::time_point begin = loop.now;
    loop.run();
    ASSERT_TRUE(loop.failed);
    EXPECT_EQ(loop.broken, 4);
    const auto waited = loop.now - begin;
    EXPECT_GE(waited, retry.first_delay * 15 * 3 / 4);
    EXPECT_LE(waited, retry.first_delay * 15);
}

TEST(ClientSession, BudgetLevelAndTargetErrorReachTheServer) {
    Loopback budget({.byte_budget = 4000});
    budget.run();
    EXPECT_EQ(budget.satisfied, EndReason::Budget);
    std::uint64_t bytes = budget.model->header().size();
    for (const Received& r : budget.received) bytes += r.payload.size();
    EXPECT_LE(bytes, 4000u);
    EXPECT_GT(bytes, 3500u);

    Loopback level({.max_level = 1});
    level.run();
    for (const Received& r : level.received) EXPECT_LE(r.id.level, 1);
    EXPECT_EQ(level.received.size(), 1u + 2 * 4 * 4);

    Loopback error({.target_error = 0.06f});
    error.run();
    EXPECT_LE(error.received.back().error, 0.06f);
    EXPECT_GT(error.received[error.received.size() - 2].error, 0.06f);
}

TEST(ClientSession, WantsMoreLaterWithoutGettingAnythingTwice) {
    Loopback loop({.max_level = 1});
    loop.run();
    const std::size_t first = loop.received.size();
    loop.satisfied.reset();
    loop.perform(loop.client.want({}, loop.now));
    loop.settle();
    EXPECT_GT(loop.received.size(), first);
    loop.expect_all_received_once();
}

TEST(ClientSession, WantsMoreLaterOverANewConnectionToo) {
    Loopback loop({.max_level = 1});
    loop.run();
    loop.cut();
    EXPECT_FALSE(loop.failed);
    loop.satisfied.reset();
    loop.perform(loop.client.want({}, loop.now));
    loop.settle();
    EXPECT_EQ(loop.resumed, 1);
    loop.expect_all_received_once();
}

TEST(ClientSession, CancelInMidStreamEndsIt) {
    Loopback loop;
    loop.perform(loop.client.start(loop.now));
    while (loop.received.size() < 3) loop.step();
    loop.perform(loop.client.cancel(loop.now));
    loop.settle();
    EXPECT_EQ(loop.satisfied, EndReason::Cancelled);
    EXPECT_LT(loop.received.size(), loop.model->toc().chunks.size());
}

TEST(ClientSession, CancelWhileNotConnectedEndsItAtOnce) {
    Loopback loop;
    loop.perform(loop.client.start(loop.now));
    loop.perform(loop.client.cancel(loop.now));
    EXPECT_EQ(loop.satisfied, EndReason::Cancelled);
    EXPECT_FALSE(loop.connecting);
}

TEST(ClientSession, ModelReplacedBetweenConnectionsIsBegunAnewAndNeverMixed) {
    Loopback loop;
    loop.perform(loop.client.start(loop.now));
    while (loop.received.size() < 5) loop.step();
    loop.model = MemoryModel::make(make_stream_file({.seed = 2}));
    loop.cut();
    loop.settle();
    EXPECT_EQ(loop.satisfied, EndReason::Complete);
    EXPECT_EQ(loop.restarted, 1);
    EXPECT_EQ(loop.opened, 2);
    loop.expect_all_received_once();
}

TEST(ClientSession, ModelOverwrittenInMidStreamIsBegunAnewAndNeverMixed) {
    Loopback loop;
    loop.perform(loop.client.start(loop.now));
    while (loop.received.size() < 5) loop.step();
    loop.model->intact_ = false;
    loop.model = MemoryModel::make(make_stream_file({.seed = 2}));
    loop.settle();
    EXPECT_EQ(loop.satisfied, EndReason::Complete);
    EXPECT_EQ(loop.restarted, 1);
    loop.expect_all_received_once();
}

TEST(ClientSession, DamagedChunkIsFetchedAgainAndThreeTimesIsTheEnd) {
    Loopback once;
    once.damage_offset = once.model->toc().chunks[7].offset;
    once.damage_times = 1;
    once.run();
    EXPECT_EQ(once.satisfied, EndReason::Complete);
    EXPECT_EQ(once.broken, 1);
    once.expect_all_received_once();

    Loopback always;
    always.damage_offset = always.model->toc().chunks[7].offset;
    always.damage_times = 1000;
    always.run();
    ASSERT_TRUE(always.failed);
    EXPECT_NE(always.failed->message.find("chunk 7"), std::string::npos);
    EXPECT_EQ(always.received.size(), 7u);
}

TEST(ClientSession, SilentServerCountsAsBroken) {
    Loopback loop;
    loop.perform(loop.client.start(loop.now));
    loop.step();
    loop.to_server.clear();  // lost on the way
    loop.settle();
    EXPECT_EQ(loop.broken, 1);
    EXPECT_EQ(loop.satisfied, EndReason::Complete);
}

TEST(ClientSession, IdleConnectionIsKeptAliveByPings) {
    Loopback loop;
    loop.run();
    for (int i = 0; i < 20; ++i) {
        loop.now = *loop.timer;
        loop.perform(loop.client.on_timer(loop.now));
        while (loop.step()) {
        }
        if (loop.server) loop.perform_server(loop.server->on_timer(loop.now));
    }
    EXPECT_TRUE(loop.server.has_value());
    EXPECT_FALSE(loop.server_closed);
    EXPECT_EQ(loop.broken, 0);
}

TEST(ClientSession, DrainingServerIsComeBackTo) {
    Loopback loop;
    loop.perform(loop.client.start(loop.now));
    while (loop.received.size() < 2) loop.step();
    loop.perform(loop.client.want({.max_level = 200}, loop.now));
    loop.perform_server(loop.server->on_drain(loop.now));
    loop.settle();
    EXPECT_EQ(loop.satisfied, EndReason::Complete);
    EXPECT_EQ(loop.resumed, 1);
    loop.expect_all_received_once();
}

TEST(ClientSession, UnknownModelFailsWithTheServersSentence) {
    Session session("nothing", "", {});
    const Clock::time_point now{};
    (void)session.start(now);
    (void)session.on_connected(now);
    Bytes in = write_message(protocol::Hello{});
    const Bytes error = write_message(protocol::ErrorMessage{protocol::ErrorCode::NotFound, "no such model"});
    in.insert(in.end(), error.begin(), error.end());
    std::optional<Error> why;
    for (const Action& a : session.on_bytes(in, now))
        if (const auto* f = std::get_if<Failed>(&a)) why = f->why;
    ASSERT_TRUE(why);
    EXPECT_NE(why->message.find("no such model"), std::string::npos);
}

TEST(ClientSession, RandomBytesEndInAnErrorAndNeverInAChunk) {
    std::mt19937 random(5);
    const Clock::time_point now{};
    for (int round = 0; round < 3000; ++round) {
        Session session("bunny", "", {});
        (void)session.start(now);
        (void)session.on_connected(now);
        Bytes in = round % 2 == 0 ? write_message(protocol::Hello{}) : Bytes{};
        for (std::size_t n = random() % 300; n > 0; --n)
            in.push_back(static_cast<std::byte>(random() % (round % 3 == 0 ? 13 : 256)));
        for (const Action& a : session.on_bytes(in, now)) EXPECT_FALSE(std::holds_alternative<Received>(a));
    }
}

// What the server says, cut at every byte: the client waits for the rest, and takes no harm when it never comes.
TEST(ClientSession, EveryTruncationOfTheConversationLeavesWholeChunksOnly) {
    const auto model = MemoryModel::make(make_stream_file({.tiles = 1, .levels = 1, .layers = 1, .payload_bytes = 40}));
    server::ServerLimits limits;
    server::Session server([&](std::string_view) -> Result<server::ModelPtr> { return server::ModelPtr(model); },
                           limits);
    const Clock::time_point now{};
    (void)server.on_start(now);
    Session asking("bunny", "", {});
    (void)asking.start(now);
    Bytes said;
    for (const Action& a : asking.on_connected(now))
        if (const auto* b = std::get_if<SendBytes>(&a))
            for (const server::Action& s : server.on_bytes(b->bytes, now)) {
                if (const auto* bytes = std::get_if<server::SendBytes>(&s))
                    said.insert(said.end(), bytes->bytes.begin(), bytes->bytes.end());
                if (const auto* range = std::get_if<server::SendRange>(&s)) {
                    Bytes payload(range->length);
                    ASSERT_TRUE(range->model->read(range->offset, payload).ok());
                    said.insert(said.end(), payload.begin(), payload.end());
                }
            }
    std::size_t most = 0;
    for (std::size_t n = 0; n <= said.size(); ++n) {
        Session session("bunny", "", {});
        (void)session.start(now);
        (void)session.on_connected(now);
        std::size_t chunks = 0;
        for (const Action& a :
             session.on_bytes(Bytes(said.begin(), said.begin() + static_cast<std::ptrdiff_t>(n)), now)) {
            EXPECT_FALSE(std::holds_alternative<Failed>(a)) << n;
            chunks += std::holds_alternative<Received>(a);
        }
        EXPECT_GE(chunks, most);
        most = chunks;
    }
    EXPECT_EQ(most, model->toc().chunks.size());
}

}  // namespace
}  // namespace mvw::client
