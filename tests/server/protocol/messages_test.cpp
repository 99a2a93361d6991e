#include "server/protocol/messages.h"

#include <gtest/gtest.h>

#include <random>

#include "server/protocol/address.h"
#include "server/protocol/message_stream.h"

namespace mvw::protocol {
namespace {

Bytes bytes_of(std::initializer_list<unsigned> values) {
    Bytes out;
    for (const unsigned v : values) out.push_back(static_cast<std::byte>(v));
    return out;
}

ChunkSet set_of(std::initializer_list<std::uint32_t> indices) {
    ChunkSet set;
    for (const std::uint32_t i : indices) set.insert(i);
    return set;
}

Request sample_request() {
    Request r;
    r.id = 7;
    r.max_level = 4;
    r.max_layer = 9;
    r.other_priority = 2;
    r.target_error = 0.25f;
    r.byte_budget = 1u << 20;
    r.tiles = {{0, 3, 9, 255}, {1, 0, 0, 2}};
    r.held = set_of({0, 1, 2, 5, 1000});
    return r;
}

Open sample_open() {
    return {"scans/bunny", "token", {1, 2, 3}, sample_request()};
}

// One of each kind, as bytes.
std::vector<Bytes> one_of_each() {
    static const Bytes payload = bytes_of({1, 2, 3, 4});
    Bytes chunk = write_chunk_head(3, {{0, 1, 2, 3, Channel::Geometry}, 100, 4, 0xAABBCCDD, 0.5f});
    chunk.insert(chunk.end(), payload.begin(), payload.end());
    Bytes index = write_index_head(4);
    index.insert(index.end(), payload.begin(), payload.end());
    return {write_message(Hello{}),
            write_message(sample_open()),
            write_message(sample_request()),
            write_message(Cancel{7}),
            write_message(GetIndex{}),
            write_message(Ping{42}),
            write_message(Pong{42}),
            write_message(Model{5, 1000, 900, payload}),
            chunk,
            write_message(End{7, EndReason::Budget, 3, 99}),
            index,
            write_message(ErrorMessage{ErrorCode::NotFound, "no such model"})};
}

template <typename M>
M read_as(const Bytes& bytes) {
    Result<Parsed> parsed = read_message(bytes, {});
    EXPECT_TRUE(parsed.ok());
    EXPECT_EQ(parsed->consumed, bytes.size());
    return std::get<M>(std::move(parsed->message));
}

Errc code_of(const Bytes& bytes, const MessageLimits& limits = {}) {
    const Result<Parsed> parsed = read_message(bytes, limits);
    EXPECT_FALSE(parsed.ok());
    return parsed.ok() ? Errc::Io : parsed.error().code;
}

TEST(ChunkSet, HoldsExactlyWhatWasInsertedInAnyOrder) {
    std::mt19937 random(3);
    ChunkSet set;
    std::vector<bool> expected(500);
    for (int n = 0; n < 400; ++n) {
        const auto i = static_cast<std::uint32_t>(random() % expected.size());
        set.insert(i);
        expected[i] = true;
    }
    std::uint64_t count = 0;
    for (std::uint32_t i = 0; i < expected.size(); ++i) {
        EXPECT_EQ(set.contains(i), expected[i]) << i;
        count += expected[i];
    }
    EXPECT_EQ(set.count(), count);
    for (std::size_t r = 1; r < set.ranges().size(); ++r)
        EXPECT_GT(set.ranges()[r].first, set.ranges()[r - 1].last + 1) << "ranges that touch were not merged";
}

TEST(ChunkSet, WorksUpToTheLastIndex) {
    ChunkSet set = set_of({0xFFFFFFFFu, 0, 0xFFFFFFFEu});
    EXPECT_TRUE(set.contains(0xFFFFFFFFu));
    EXPECT_EQ(set.ranges().size(), 2u);
    ByteWriter out;
    set.write(out);
    ByteReader in(out.view());
    EXPECT_EQ(ChunkSet::read(in).value(), set);
}

TEST(ChunkSet, MergeIsTheUnion) {
    std::mt19937 random(4);
    for (int round = 0; round < 50; ++round) {
        ChunkSet a, b, both;
        for (int n = 0; n < 40; ++n) {
            const std::uint32_t i = random() % 100, k = random() % 100;
            a.insert(i);
            b.insert(k);
            both.insert(i);
            both.insert(k);
        }
        a.merge(b);
        EXPECT_EQ(a, both);
    }
}

TEST(ChunkSet, AThousandNeighboursTakeThreeBytes) {
    ChunkSet set;
    for (std::uint32_t i = 0; i < 1000; ++i) set.insert(i);
    ByteWriter out;
    set.write(out);
    EXPECT_EQ(out.view(), bytes_of({1, 0, 0xE7, 0x07}));
}

TEST(ChunkSet, RefusesRangesBeyond32BitsAndCountsBeyondTheBytes) {
    ByteWriter beyond;
    beyond.varint(1);
    beyond.varint(0xFFFFFFFF);
    beyond.varint(1);
    ByteReader in(beyond.view());
    EXPECT_EQ(ChunkSet::read(in).error().code, Errc::Malformed);

    ByteWriter many;
    many.varint(1u << 30);
    many.u32(0);
    ByteReader in2(many.view());
    EXPECT_EQ(ChunkSet::read(in2).error().code, Errc::Malformed);
}

// The worked bytes of PROTOCOL.md 7.
TEST(Messages, HaveTheBytesThatTheDocumentShows) {
    Hello hello;
    hello.max_message_bytes = 0x40000;
    hello.keep_alive_seconds = 300;
    EXPECT_EQ(write_message(hello),
              bytes_of({0x12, 0, 0, 0, 1, 'M', 'V', 'W', 'P', 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0x2C, 1}));
    Open open;
    open.model = "bunny";
    open.request.id = 1;
    EXPECT_EQ(write_message(open),
              bytes_of({0x2E, 0, 0, 0, 2, 5, 0, 'b', 'u',  'n',  'n', 'y', 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                        0,    0, 0, 0, 1, 0, 0, 0,   0xFF, 0xFF, 1,   0,   0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(write_message(End{1, EndReason::Complete, 17, 1000}),
              bytes_of({0x11, 0, 0, 0, 10, 1, 0, 0, 0, 0, 17, 0, 0, 0, 0xE8, 3, 0, 0, 0, 0, 0, 0}));
}

TEST(Messages, ComeBackAsTheyWereWritten) {
    const Hello hello{3, 2, 1, 77, 30};
    EXPECT_EQ(read_as<Hello>(write_message(hello)), hello);
    EXPECT_EQ(read_as<Open>(write_message(sample_open())), sample_open());
    EXPECT_EQ(read_as<Request>(write_message(sample_request())), sample_request());
    EXPECT_EQ(read_as<Cancel>(write_message(Cancel{9})), Cancel{9});
    EXPECT_EQ(read_as<Ping>(write_message(Ping{9})), Ping{9});
    EXPECT_EQ(read_as<Pong>(write_message(Pong{9})), Pong{9});
    const End end{1, EndReason::Cancelled, 2, 3};
    EXPECT_EQ(read_as<End>(write_message(end)), end);
    const ErrorMessage error{ErrorCode::Changed, "changed"};
    EXPECT_EQ(read_as<ErrorMessage>(write_message(error)), error);
}

TEST(Messages, ChunkKeepsItsPlaceItsNameAndItsPayload) {
    const Bytes bytes = one_of_each()[8];
    const Result<Parsed> parsed = read_message(bytes, {});
    ASSERT_TRUE(parsed.ok());
    const auto& chunk = std::get<Chunk>(parsed->message);
    EXPECT_EQ(chunk.index, 3u);
    EXPECT_EQ(chunk.id, (ChunkId{0, 1, 2, 3, Channel::Geometry}));
    EXPECT_EQ(chunk.crc32c, 0xAABBCCDDu);
    EXPECT_EQ(chunk.error, 0.5f);
    EXPECT_EQ(Bytes(chunk.payload.begin(), chunk.payload.end()), bytes_of({1, 2, 3, 4}));
}

TEST(Messages, EveryPrefixAsksForMoreData) {
    for (const Bytes& whole : one_of_each())
        for (std::size_t n = 0; n < whole.size(); ++n)
            EXPECT_EQ(code_of(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n))), Errc::NeedMoreData)
                << "type " << static_cast<int>(whole[4]) << ", prefix of " << n;
}

// A message whose length says that it ends early: fields that are cut off are a contradiction, not a wish for more.
TEST(Messages, BodyCutShortIsMalformedOrAnotherSoundMessage) {
    for (const Bytes& whole : one_of_each()) {
        for (std::size_t n = kHeadBytes; n < whole.size(); ++n) {
            Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
            cut[0] = static_cast<std::byte>(n - kHeadBytes);
            const Result<Parsed> parsed = read_message(cut, {});
            const bool ends_in_raw_bytes =
                whole[4] >= std::byte{8} && whole[4] != std::byte{10};  // payloads may be short
            EXPECT_TRUE(parsed.ok() ? ends_in_raw_bytes : parsed.error().code == Errc::Malformed)
                << "type " << static_cast<int>(whole[4]) << ", cut at " << n;
        }
    }
}

TEST(Messages, BytesBeyondTheFieldsAreMalformed) {
    for (Bytes message : one_of_each()) {
        const auto type = static_cast<MessageType>(message[4]);
        if (type == MessageType::Model || type == MessageType::Chunk || type == MessageType::Index) continue;
        message.push_back(std::byte{0});
        message[0] = static_cast<std::byte>(message.size() - kHeadBytes);
        EXPECT_EQ(code_of(message), Errc::Malformed) << "type " << static_cast<int>(type);
    }
}

TEST(Messages, TooLargeIsRefusedByTheHeadAlone) {
    MessageLimits limits;
    limits.max_body_bytes = 100;
    EXPECT_EQ(code_of(bytes_of({101, 0, 0, 0, 6}), limits), Errc::LimitExceeded);
    EXPECT_EQ(code_of(bytes_of({0xFF, 0xFF, 0xFF, 0xFF, 6}), limits), Errc::LimitExceeded);
    EXPECT_EQ(code_of(bytes_of({100, 0, 0, 0, 6}), limits), Errc::NeedMoreData);
}

TEST(Messages, UnknownTypeIsUnsupported) {
    EXPECT_EQ(code_of(bytes_of({0, 0, 0, 0, 0})), Errc::Unsupported);
    EXPECT_EQ(code_of(bytes_of({0, 0, 0, 0, 13})), Errc::Unsupported);
}

TEST(Messages, NamesTokensAndTilesAreHeldToTheirLimits) {
    MessageLimits limits;
    limits.max_name_bytes = 10;
    EXPECT_EQ(code_of(write_message(sample_open()), limits), Errc::LimitExceeded);
    limits = {};
    limits.max_token_bytes = 4;
    EXPECT_EQ(code_of(write_message(sample_open()), limits), Errc::LimitExceeded);
    limits = {};
    limits.max_tiles = 1;
    EXPECT_EQ(code_of(write_message(sample_request()), limits), Errc::LimitExceeded);
}

TEST(Messages, ForeignGreetingIsMalformed) {
    Bytes hello = write_message(Hello{});
    hello[kHeadBytes] = std::byte{'X'};
    EXPECT_EQ(code_of(hello), Errc::Malformed);
}

TEST(Messages, TargetErrorMustBeANumber) {
    Request r;
    r.target_error = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(code_of(write_message(r)), Errc::Malformed);
    r.target_error = -1;
    EXPECT_EQ(code_of(write_message(r)), Errc::Malformed);
}

TEST(MessageStream, ByteAtATimeEqualsAllAtOnce) {
    Bytes all;
    for (const Bytes& m : one_of_each()) all.insert(all.end(), m.begin(), m.end());
    MessageStream stream{MessageLimits{}};
    std::vector<std::size_t> kinds;
    for (const std::byte b : all) {
        stream.add(ByteSpan(&b, 1));
        for (Result<Message> m = stream.next(); m.ok(); m = stream.next()) kinds.push_back(m->index());
    }
    EXPECT_FALSE(stream.partial());
    EXPECT_EQ(kinds, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}));
}

TEST(HostPort, ReadsNamesAddressesAndPorts) {
    EXPECT_EQ(parse_host_port("localhost").value(), (HostPort{"localhost", kDefaultPort}));
    EXPECT_EQ(parse_host_port("127.0.0.1:0").value(), (HostPort{"127.0.0.1", 0}));
    EXPECT_EQ(parse_host_port("[::1]:99").value(), (HostPort{"::1", 99}));
    EXPECT_EQ(to_string(HostPort{"::1", 99}), "[::1]:99");
    for (const char* bad : {"", ":1", "a:", "a:b", "a:65536", "a:-1", "a:1x", "::1", "[::1", "[::1]x"})
        EXPECT_FALSE(parse_host_port(bad).ok()) << bad;
}

}  // namespace
}  // namespace mvw::protocol
