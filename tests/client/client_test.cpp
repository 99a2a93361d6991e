// The client library against a server, with a model that really is one.
#include "client/client.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "codec/encoder.h"
#include "server/server.h"
#include "tests/support/certificate.h"
#include "tests/support/plain_server.h"
#include "tests/support/shapes.h"
#include "tests/support/stream_models.h"

namespace mvw::client {
namespace {

const Bytes& torus_file() {
    static const Bytes file = [] {
        EncodeOptions options;
        options.threads = 1;
        return encode(torus(48, 24), options).value().file;
    }();
    return file;
}

class StreamTest : public testing::Test {
 protected:
    void SetUp() override {
        folder_.put("torus.mvw", torus_file());
        server::ServerOptions options;
        options.folder = folder_.path();
        options.tcp.port = options.http.port = 0;
        server_ = server::Server::start(options).value();
    }
    [[nodiscard]] Url url() const { return {Scheme::Tcp, server_->tcp_address(), "torus", false, {}}; }

    test::TemporaryFolder folder_;
    std::unique_ptr<server::Server> server_;
};

// A torus of nearly three units across, with bumps for its levels to hold, in 16 tiles.
const Bytes& tiled_file() {
    static const Bytes file = [] {
        EncodeOptions options;
        options.threads = 1;
        options.tile_count = 16;
        Mesh mesh = torus(192, 96);
        for (Vec3& p : mesh.positions) p *= 1 + 0.03 * std::sin(12 * p.x) * std::sin(15 * p.y) * std::sin(14 * p.z);
        return encode(mesh, options).value().file;
    }();
    return file;
}

/// Every way in, with and without TLS.
class EveryWayTest : public testing::TestWithParam<std::tuple<Scheme, bool>> {
 protected:
    void start(server::ServerOptions options = {}) {
        folder_.put("torus.mvw", torus_file());
        options.folder = folder_.path();
        options.tcp.port = options.http.port = 0;
        if (std::get<1>(GetParam())) {
            test::make_certificate(folder_.path("cert.pem"), folder_.path("key.pem"));
            options.tls_cert = folder_.path("cert.pem");
            options.tls_key = folder_.path("key.pem");
            options_.ca_file = options.tls_cert;
        }
        server_ = server::Server::start(options).value();
        const auto [scheme, tls] = GetParam();
        url_ = {scheme, scheme == Scheme::Tcp ? server_->tcp_address() : server_->http_address(), "torus", tls,
                "/models/torus.mvw"};
        options_.keep_chunks = true;
        options_.retry.first_delay = std::chrono::milliseconds(5);
    }

    test::TemporaryFolder folder_;
    std::unique_ptr<server::Server> server_;
    Url url_;
    StreamOptions options_;
};

TEST_P(EveryWayTest, BringsTheFileByteForByte) {
    start();
    Stream stream(url_, options_, {});
    const Result<Summary> summary = stream.wait();
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    EXPECT_EQ(stream.feed().file().value(), torus_file());
    EXPECT_TRUE(summary->first_mesh_seconds);
}

TEST_P(EveryWayTest, ComesNoFasterThanThePace) {
    start();
    const auto pace = std::make_shared<Pace>();
    pace->bytes_per_second = 2.0 * static_cast<double>(torus_file().size());
    options_.pace = pace;
    Stream stream(url_, options_, {});
    const Result<Summary> summary = stream.wait();
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    EXPECT_GE(summary->seconds, 0.35);
    EXPECT_EQ(stream.feed().file().value(), torus_file());
}

TEST_P(EveryWayTest, WaitingLateIsNoLongWait) {
    start();
    std::atomic<bool> refined = false;
    Callbacks callbacks;
    callbacks.refined = [&](const Refinement&, const Decoder&) { refined = true; };
    Stream stream(url_, options_, std::move(callbacks));
    while (!refined) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(400));  // all of it has come by now
    ASSERT_TRUE(stream.wait().ok());
    EXPECT_EQ(stream.feed().file().value(), torus_file());
    EXPECT_TRUE(stream.wait().ok()) << "and once more";
}

TEST_P(EveryWayTest, LevelAndThenTheRest) {
    start();
    options_.wants.max_level = 1;
    Stream stream(url_, options_, {});
    ASSERT_TRUE(stream.wait().ok());
    EXPECT_LE(stream.feed().decoder().state().level, 1u);
    const auto coarse = stream.feed().decoder().state().chunks;
    stream.want({});
    const Result<Summary> summary = stream.wait();
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    EXPECT_GT(stream.feed().decoder().state().chunks, coarse);
    EXPECT_EQ(stream.feed().file().value(), torus_file());
}

// A small picture needs no level whose triangles it does not show; the rest comes when
// the camera asks for it.
TEST_P(EveryWayTest, ViewBringsWhatShowsAndTheRestWhenItIsLookedAt) {
    start();
    folder_.put("torus.mvw", tiled_file());
    View view;
    view.from_model = {0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, -4, 1};  // from (4, 0, 0), along -x
    view.scale_x = view.scale_y = 3;
    view.height = 300;
    view.pixel_error = 2;
    view.outside = false;
    options_.view = view;
    Stream stream(url_, options_, {});
    const Result<Summary> near = stream.wait();
    ASSERT_TRUE(near.ok()) << near.error().message;
    const std::uint64_t first = stream.feed().state().bytes, all = tiled_file().size();
    EXPECT_LT(first, 2 * all / 3);
    const unsigned finest = stream.feed().decoder().header()->parts[0].levels;
    EXPECT_GT(stream.feed().state().level, 0u) << "nothing came but the base";
    EXPECT_LE(stream.feed().state().level, finest);

    view.from_model[0] = view.from_model[10] = -0.01f;  // a little aside
    view.pixel_error = 0;
    view.outside = true;
    stream.look(view);
    const Result<Summary> whole = stream.wait();
    ASSERT_TRUE(whole.ok()) << whole.error().message;
    const Result<Bytes> file = stream.feed().file();
    ASSERT_TRUE(file.ok());
    EXPECT_TRUE(*file == tiled_file());
}

TEST_P(EveryWayTest, CacheSavesWhatItHasAndNothingElse) {
    start();
    options_.cache_folder = folder_.path("cache");
    options_.wants.byte_budget = torus_file().size() / 2;
    std::uint64_t half = 0;
    {
        Stream stream(url_, options_, {});
        ASSERT_TRUE(stream.wait().ok());
        half = stream.feed().decoder().state().bytes;
    }
    options_.wants = {};
    for (int run = 0; run < 2; ++run) {
        Stream stream(url_, options_, {});
        const Result<Summary> summary = stream.wait();
        ASSERT_TRUE(summary.ok()) << summary.error().message;
        EXPECT_EQ(stream.feed().file().value(), torus_file());
        EXPECT_GT(summary->cached_bytes, run == 0 ? half / 2 : torus_file().size() * 3 / 4);
    }
}

TEST_P(EveryWayTest, TokensOpenAndTheirAbsenceDoesNot) {
    const std::string key = "a key of at least 16 bytes";
    server::ServerOptions server;
    server.tokens.emplace(std::vector<std::string>{key});
    start(server);
    {
        Stream stream(url_, options_, {});
        const Result<Summary> summary = stream.wait();
        ASSERT_FALSE(summary.ok());
    }
    options_.token = server::make_token(key, "to*", 1ll << 40).value();
    Stream stream(url_, options_, {});
    EXPECT_TRUE(stream.wait().ok());
}

TEST_P(EveryWayTest, StrangersCertificateIsRefused) {
    start();
    if (!url_.tls) return;
    options_.ca_file.clear();
    options_.retry.first_attempts = 1;
    Stream stream(url_, options_, {});
    ASSERT_FALSE(stream.wait().ok());
}

INSTANTIATE_TEST_SUITE_P(Ways, EveryWayTest,
                         testing::Combine(testing::Values(Scheme::Tcp, Scheme::WebSocket, Scheme::Http),
                                          testing::Bool()));

TEST_F(StreamTest, DeliversRefinementsUpToTheWholeModel) {
    std::vector<Refinement> seen;
    Callbacks callbacks;
    callbacks.refined = [&](const Refinement& r, const Decoder& decoder) {
        EXPECT_TRUE(decoder.mesh().ok()) << "a refinement without a mesh";
        seen.push_back(r);
    };
    Stream stream(url(), {}, callbacks);
    const Result<Summary> summary = stream.wait();
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    ASSERT_GT(seen.size(), 3u);
    for (std::size_t i = 1; i < seen.size(); ++i) {
        EXPECT_GT(seen[i].state.bytes, seen[i - 1].state.bytes);
        EXPECT_LE(seen[i].state.error, seen[i - 1].state.error);
        EXPECT_GE(seen[i].state.level, seen[i - 1].state.level);
    }
    const Mesh mesh = stream.feed().decoder().mesh().value(), whole = decode(torus_file()).value();
    EXPECT_EQ(mesh.positions, whole.positions);
    EXPECT_EQ(mesh.faces, whole.faces);
    ASSERT_TRUE(summary->first_mesh_seconds);
    EXPECT_LE(*summary->first_mesh_seconds, summary->seconds);
}

TEST_F(StreamTest, ReceivedChunksMakeAValidFileOfTheSameModel) {
    StreamOptions options;
    options.keep_chunks = true;
    options.wants.byte_budget = torus_file().size() / 2;
    Stream stream(url(), options, {});
    const Result<Summary> summary = stream.wait();
    ASSERT_TRUE(summary.ok());
    EXPECT_EQ(summary->reason, protocol::EndReason::Budget);
    EXPECT_LE(stream.feed().decoder().state().bytes, options.wants.byte_budget);
    const Bytes file = stream.feed().file().value();
    const FileHeader header = read_header(file).value();
    EXPECT_TRUE(read_toc(header, ByteSpan(file).subspan(header.index_offset), file.size()).ok());
    EXPECT_EQ(decode(file).value().positions, stream.feed().decoder().mesh().value().positions);
}

TEST_F(StreamTest, WantsMoreLaterAndEndsAtTheSameMesh) {
    StreamOptions options;
    options.wants.max_level = 0;
    Stream stream(url(), options, {});
    ASSERT_TRUE(stream.wait().ok());
    const DecodeState coarse = stream.feed().decoder().state();
    EXPECT_EQ(coarse.level, 0u);
    EXPECT_GT(stream.feed().state().error, coarse.error) << "the file's statement presumes finer levels";
    stream.want({});
    ASSERT_TRUE(stream.wait().ok());
    const DecodeState fine = stream.feed().state();
    EXPECT_GT(fine.chunks, coarse.chunks);
    EXPECT_LE(fine.error, coarse.error);
    EXPECT_EQ(stream.feed().decoder().mesh().value().positions, decode(torus_file()).value().positions);
}

TEST_F(StreamTest, CancelledItEndsSoonWithWhatItHas) {
    Stream stream(url(), {}, {});
    stream.cancel();
    EXPECT_TRUE(stream.wait().ok());
}

TEST_F(StreamTest, ServerWithoutRangeGivesTheWholeModelToo) {
    const test::PlainServer plain(torus_file());
    StreamOptions options;
    options.keep_chunks = true;
    Stream stream({Scheme::Http, plain.address(), "torus", false, "/torus.mvw"}, options, {});
    const Result<Summary> summary = stream.wait();
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    EXPECT_EQ(stream.feed().file().value(), torus_file());
    EXPECT_EQ(plain.requests(), 1u);
}

TEST_F(StreamTest, ServerThatIsNotThereIsAnErrorAfterAFewTries) {
    const Url there = url();
    server_.reset();
    StreamOptions options;
    options.retry.first_delay = std::chrono::milliseconds(1);
    int broken = 0;
    Callbacks callbacks;
    callbacks.broken = [&](const Broken&) { ++broken; };
    Stream stream(there, options, callbacks);
    const Result<Summary> summary = stream.wait();
    ASSERT_FALSE(summary.ok());
    EXPECT_EQ(summary.error().code, Errc::Io);
    EXPECT_EQ(broken, 3);
}

TEST_F(StreamTest, LeavingInMidStreamIsClean) {
    for (int i = 0; i < 20; ++i) Stream stream(url(), {}, {});
    Stream last(url(), {}, {});
    EXPECT_TRUE(last.wait().ok());
}

}  // namespace
}  // namespace mvw::client
