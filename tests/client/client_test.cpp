// The client library against a server, with a model that really is one.
#include "client/client.h"

#include <gtest/gtest.h>

#include "codec/encoder.h"
#include "server/server.h"
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
    [[nodiscard]] Url url() const { return {Scheme::Tcp, server_->tcp_address(), "torus"}; }

    test::TemporaryFolder folder_;
    std::unique_ptr<server::Server> server_;
};

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
    options.wants.max_level = 1;
    Stream stream(url(), options, {});
    ASSERT_TRUE(stream.wait().ok());
    const DecodeState coarse = stream.feed().decoder().state();
    EXPECT_LE(coarse.level, 1u);
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
