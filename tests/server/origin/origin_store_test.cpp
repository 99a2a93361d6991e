// A server whose models are on another one, over real sockets on the loopback.
#include "server/origin/origin_store.h"

#include <gtest/gtest.h>

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include <filesystem>
#include <thread>

#include "server/server.h"
#include "tests/support/certificate.h"
#include "tests/support/downloader.h"
#include "tests/support/plain_server.h"
#include "tests/support/program.h"

namespace mvw {
namespace {

using namespace std::chrono_literals;
using test::Downloader;
using test::make_stream_file;

const test::StreamModelShape kLarge{.tiles = 4, .levels = 3, .layers = 4, .payload_bytes = 400'000};

class OriginTest : public testing::Test {
 protected:
    static std::unique_ptr<server::Server> start(server::ServerOptions options) {
        options.tcp.host = options.http.host = "127.0.0.1";
        options.tcp.port = 0;
        Result<std::unique_ptr<server::Server>> server = server::Server::start(std::move(options));
        EXPECT_TRUE(server.ok()) << server.error().message;
        return server.ok() ? std::move(server).value() : nullptr;
    }
    void start_far(std::uint16_t port = 0) {
        far_.reset();
        server::ServerOptions options;
        options.folder = models_.path();
        options.http.port = port;
        far_ = start(options);
        origin_.url = "http://127.0.0.1:" + std::to_string(far_->http_address().port) + "/models";
    }
    void start_near() {
        near_.reset();
        server::ServerOptions options;
        options.folder = cache_.path();
        options.http.port = 0;
        options.origin = origin_;
        near_ = start(options);
    }
    // What a client without a decoder gets by TCP: all of the file, or a failure.
    void expect_stream_of(const std::string& name, const Bytes& file) {
        Downloader client(near_->tcp_address(), name);
        ASSERT_TRUE(client.wait());
        ASSERT_FALSE(client.failed) << client.failed->message;
        client.expect_all_of(file);
    }
    std::string failure_of(const std::string& name) {
        Downloader client(near_->tcp_address(), name);
        EXPECT_TRUE(client.wait());
        return client.failed ? client.failed->message : "";
    }
    double metric(const std::string& name) {
        const std::string text = read_http("/metrics");
        const std::size_t at = text.find("\n" + name + " ");
        return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
    }
    std::string read_http(const std::string& target) {
        boost::asio::io_context io;
        boost::asio::ip::tcp::socket socket(io);
        socket.connect({boost::asio::ip::make_address("127.0.0.1"), near_->http_address().port});
        const std::string request = "GET " + target + " HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n";
        boost::asio::write(socket, boost::asio::buffer(request));
        std::string all;
        boost::system::error_code error;
        boost::asio::read(socket, boost::asio::dynamic_buffer(all), error);
        return all;
    }
    std::uint64_t cache_bytes() const {
        std::uint64_t total = 0;
        for (const auto& entry : std::filesystem::directory_iterator(cache_.path())) total += entry.file_size();
        return total;
    }

    test::TemporaryFolder models_, cache_;
    server::OriginOptions origin_{.fresh_time = 50ms};
    std::unique_ptr<server::Server> far_, near_;
};

TEST_F(OriginTest, SeveralClientsAtOnceGetTheirWholeModelsAndTheStoreIsAskedOnce) {
    const Bytes a = make_stream_file({.payload_bytes = 20'000}),
                b = make_stream_file({.payload_bytes = 9'000, .seed = 2});
    models_.put("a.mvw", a);
    models_.put("sub dir/b.mvw", b);
    start_far();
    origin_.fresh_time = 60s;
    start_near();
    std::vector<std::unique_ptr<Downloader>> clients;
    clients.reserve(6);
    for (int i = 0; i < 6; ++i)
        clients.push_back(std::make_unique<Downloader>(near_->tcp_address(), i % 2 == 0 ? "a" : "sub dir/b.mvw"));
    for (int i = 0; i < 6; ++i) {
        ASSERT_TRUE(clients[i]->wait());
        ASSERT_FALSE(clients[i]->failed) << clients[i]->failed->message;
        clients[i]->expect_all_of(i % 2 == 0 ? a : b);
    }
    EXPECT_LE(metric("mvw_origin_bytes_total"), 1.0 * (a.size() + b.size()) + 2 * 128.0 * 1024);
    EXPECT_EQ(metric("mvw_origin_failures_total"), 0);
}

TEST_F(OriginTest, HttpGivesWholeFilesAndPartsOfThem) {
    const Bytes a = make_stream_file(kLarge);
    const std::string text(reinterpret_cast<const char*>(a.data()), a.size());
    models_.put("a.mvw", a);
    start_far();
    start_near();
    const std::string whole = read_http("/models/a.mvw");
    ASSERT_TRUE(whole.starts_with("HTTP/1.1 200")) << whole.substr(0, 200);
    EXPECT_TRUE(whole.ends_with(text));
    EXPECT_TRUE(read_http("/models/none.mvw").starts_with("HTTP/1.1 404"));
    EXPECT_NE(read_http("/models").find("\"name\":\"a\""), std::string::npos);
}

TEST_F(OriginTest, WhatIsOnTheDiskOutlivesTheStoreAndARestart) {
    const Bytes a = make_stream_file(kLarge);
    models_.put("a.mvw", a);
    start_far();
    start_near();
    expect_stream_of("a", a);
    start_near();
    expect_stream_of("a", a);
    EXPECT_LE(metric("mvw_origin_bytes_total"), 200'000) << "what was on the disk was fetched again";
    far_.reset();
    std::this_thread::sleep_for(100ms);
    expect_stream_of("a", a);
}

TEST_F(OriginTest, DamageInTheCacheIsNoticedAtTheStart) {
    const Bytes a = make_stream_file(kLarge);
    models_.put("a.mvw", a);
    start_far();
    start_near();
    expect_stream_of("a", a);
    near_.reset();
    for (const auto& entry : std::filesystem::directory_iterator(cache_.path()))
        if (entry.path().extension() == ".origin")
            cache_.overwrite(entry.path().filename(), Bytes(entry.file_size(), std::byte{7}));
    start_near();
    expect_stream_of("a", a);
}

TEST_F(OriginTest, ModelReplacedInTheStoreIsNoticedAndNeverMixed) {
    models_.put("a.mvw", make_stream_file(kLarge));
    start_far();
    start_near();
    Downloader client(near_->tcp_address(), "a", {}, 5);
    ASSERT_TRUE(client.wait_for_pause());
    const Bytes fresh = make_stream_file({.payload_bytes = 9'000, .seed = 2});
    models_.put("a.mvw", fresh);
    std::this_thread::sleep_for(100ms);
    client.go_on();
    ASSERT_TRUE(client.wait());
    ASSERT_FALSE(client.failed) << client.failed->message;
    expect_stream_of("a", fresh);
}

TEST_F(OriginTest, StoreThatIsAwayForAMomentInMidStreamDoesNoHarm) {
    const Bytes a = make_stream_file(kLarge);
    models_.put("a.mvw", a);
    start_far();
    const std::uint16_t port = far_->http_address().port;
    start_near();
    Downloader client(near_->tcp_address(), "a", {}, 5);
    ASSERT_TRUE(client.wait_for_pause());
    far_.reset();
    client.go_on();
    std::this_thread::sleep_for(300ms);
    start_far(port);
    ASSERT_TRUE(client.wait());
    ASSERT_FALSE(client.failed) << client.failed->message;
    client.expect_all_of(a);
}

TEST_F(OriginTest, CacheStaysWithinItsRoomAndForgetsWhatWasUsedLongestAgo) {
    start_far();
    std::vector<Bytes> files;
    for (unsigned i = 0; i < 5; ++i) {
        files.push_back(make_stream_file({.payload_bytes = 20'000, .seed = i + 1}));
        models_.put(std::to_string(i) + ".mvw", files.back());
    }
    origin_.cache_bytes = files[0].size() * 5 / 2;
    start_near();
    for (int round = 0; round < 2; ++round)
        for (unsigned i = 0; i < 5; ++i) {
            expect_stream_of(std::to_string(i), files[i]);
            EXPECT_LE(cache_bytes(), origin_.cache_bytes + 10'000) << "lists of blocks are not counted";
        }
    models_.put("large.mvw", make_stream_file({.payload_bytes = 60'000}));
    EXPECT_NE(failure_of("large").find("no room"), std::string::npos);
    cache_.put("mine.txt", Bytes(10'000'000));
    expect_stream_of("0", files[0]);
    EXPECT_TRUE(std::filesystem::exists(cache_.path("mine.txt"))) << "not the cache's own";
}

TEST_F(OriginTest, ListNamesModelsByUrlsOfTheirOwnAndIsReadAgain) {
    const Bytes a = make_stream_file(), b = make_stream_file({.seed = 2});
    models_.put("a.mvw", a);
    models_.put("b.mvw", b);
    start_far();
    const ScratchFolder lists;
    origin_.list = lists / "models";
    const std::string base = origin_.url;
    origin_.url.clear();
    write_text(origin_.list, "# signed until noon\nfirst " + base + "/a.mvw?signature=1\n");
    start_near();
    expect_stream_of("first", a);
    EXPECT_NE(failure_of("a").find("no such model"), std::string::npos);
    write_text(origin_.list, "first " + base + "/b.mvw?signature=2\nsub/second " + base + "/a.mvw\n");
    std::this_thread::sleep_for(100ms);
    expect_stream_of("first", b);
    expect_stream_of("sub/second", a);
}

TEST_F(OriginTest, NamesThatAreNoneAndFilesThatAreUnsoundAreRefused) {
    models_.put("a.mvw", make_stream_file());
    Bytes cut = make_stream_file();
    cut.resize(cut.size() / 2);
    models_.put("served/cut.mvw", cut);
    start_far();
    origin_.url += "/served";
    start_near();
    for (const char* name : {"../a", "none", "..%2Fa", "/a"})
        EXPECT_NE(failure_of(name).find("no such model"), std::string::npos) << name;
    EXPECT_TRUE(read_http("/models/cut.mvw").starts_with("HTTP/1.1 500"));
}

TEST_F(OriginTest, StoreThatIgnoresRangeIsRefusedByNameUnlessTheFileIsSmall) {
    const Bytes large = make_stream_file(kLarge), small = make_stream_file();
    ASSERT_GT(large.size(), 128u << 10);
    {
        const test::PlainServer store(large);
        origin_.url = "http://" + to_string(store.address());
        start_near();
        const std::string answer = read_http("/models/a.mvw");
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 500")) << answer.substr(0, 200);
        EXPECT_NE(answer.find("the store ignores Range"), std::string::npos) << answer;
        EXPECT_GE(metric("mvw_origin_failures_total"), 1);
    }
    near_.reset();
    const test::TemporaryFolder other;  // a cache belongs to one store
    const test::PlainServer store(small);
    server::ServerOptions options;
    options.folder = other.path();
    options.http.port = 0;
    options.origin = server::OriginOptions{.url = "http://" + to_string(store.address())};
    near_ = start(options);
    expect_stream_of("a", small);  // one answer is all of it
}

TEST_F(OriginTest, TlsStoresAreBelievedOnlyByTheirCertificate) {
    const Bytes a = make_stream_file({.payload_bytes = 20'000});
    models_.put("a.mvw", a);
    const ScratchFolder keys;
    test::make_certificate(keys / "cert.pem", keys / "key.pem");
    server::ServerOptions options;
    options.folder = models_.path();
    options.http.port = 0;
    options.tls_cert = keys / "cert.pem";
    options.tls_key = keys / "key.pem";
    far_ = start(options);
    origin_.url = "https://localhost:" + std::to_string(far_->http_address().port) + "/models";
    start_near();
    EXPECT_TRUE(read_http("/models/a.mvw").starts_with("HTTP/1.1 500")) << "nobody vouches for it";
    origin_.ca_file = keys / "cert.pem";
    start_near();
    expect_stream_of("a", a);
}

TEST_F(OriginTest, WrongAddressesFoldersAndListsAreErrorsAtTheStart) {
    server::ServerOptions options;
    options.folder = cache_.path();
    options.tcp.port = options.http.port = 0;
    options.origin = server::OriginOptions{.url = "ftp://store/a"};
    EXPECT_EQ(server::Server::start(options).error().code, Errc::InvalidArgument);
    options.origin = server::OriginOptions{.list = cache_.path("none")};
    EXPECT_EQ(server::Server::start(options).error().code, Errc::Io);
    start_far();
    start_near();
    options.origin = origin_;
    EXPECT_NE(server::Server::start(options).error().message.find("another server"), std::string::npos);
}

}  // namespace
}  // namespace mvw
