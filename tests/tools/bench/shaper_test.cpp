#include "tools/bench/shaper.h"

#include <gtest/gtest.h>

#include "server/server.h"
#include "tests/support/downloader.h"

namespace mvw::bench {
namespace {

using namespace std::chrono_literals;

class ShaperTest : public testing::Test {
 protected:
    void SetUp() override {
        folder_.put("a.mvw", file_);
        server::ServerOptions options;
        options.folder = folder_.path();
        options.tcp.port = options.http.port = 0;
        server_ = server::Server::start(options).value();
    }
    // Seconds until the whole model has come through a link.
    double seconds_over(const LinkShape& shape) {
        shaper_ = Shaper::start(server_->tcp_address(), shape).value();
        const auto begin = std::chrono::steady_clock::now();
        test::Downloader client(shaper_->address(), "a");
        EXPECT_TRUE(client.wait());
        EXPECT_FALSE(client.failed);
        client.expect_all_of(file_);
        resumed_ = client.resumed;
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    const Bytes file_ = test::make_stream_file({.payload_bytes = 2000});
    test::TemporaryFolder folder_;
    std::unique_ptr<server::Server> server_;
    std::unique_ptr<Shaper> shaper_;
    int resumed_ = 0;
};

TEST_F(ShaperTest, TakesTwoRoundTripsAndTheBytesAtLinkRate) {
    const double bytes = static_cast<double>(file_.size());
    const double expected = 2 * 0.15 + bytes * 8 / 4e6;
    const double took = seconds_over({.megabits_per_second = 4, .round_trip = 150ms});
    EXPECT_GT(took, 0.95 * expected);
    EXPECT_LT(took, expected + 1.0) << "a loaded machine may add some";
    EXPECT_EQ(shaper_->connections(), 1u);
    EXPECT_GT(shaper_->bytes_to_clients(), file_.size() * 9 / 10);
}

TEST_F(ShaperTest, StallsHoldEverythingUp) {
    const double took = seconds_over({.megabits_per_second = 8, .stall_every = 20ms, .stall_time = 100ms});
    EXPECT_GT(took, static_cast<double>(file_.size()) * 8 / 8e6 + 0.3);
}

TEST_F(ShaperTest, ResetsAreResumedWithoutAByteTwice) {
    seconds_over({.reset_after_bytes = file_.size() / 4});
    EXPECT_GE(resumed_, 3);
    // A reset takes back what is on its way: that, and a head for each connection, is all that comes again.
    EXPECT_LT(shaper_->bytes_to_clients(), file_.size() * 2);
}

}  // namespace
}  // namespace mvw::bench
