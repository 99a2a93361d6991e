// The server and the client's transport over real sockets on the loopback.
#include "server/server.h"

#include <gtest/gtest.h>

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include <thread>

#include "client/transport/wire.h"
#include "tests/support/certificate.h"
#include "tests/support/downloader.h"
#include "tests/support/stream_models.h"

namespace mvw {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using test::Downloader;
using test::make_stream_file;

// Larger than what the sockets' buffers take: a client that does not read holds its server up.
const test::StreamModelShape kLarge{.tiles = 4, .levels = 3, .layers = 4, .payload_bytes = 400'000};

class ServerTest : public testing::Test {
 protected:
    void start(std::uint16_t port = 0) {
        server_.reset();
        options_.folder = folder_.path();
        options_.tcp = {"127.0.0.1", port};
        options_.http = {"127.0.0.1", 0};
        Result<std::unique_ptr<server::Server>> server = server::Server::start(options_);
        ASSERT_TRUE(server.ok()) << server.error().message;
        server_ = std::move(server).value();
    }
    protocol::HostPort address() const { return server_->tcp_address(); }
    bool connections_become(std::size_t n) {
        for (int i = 0; i < 500 && server_->connections() != n; ++i) std::this_thread::sleep_for(10ms);
        return server_->connections() == n;
    }
    tcp::socket connect() {
        tcp::socket socket(io_);
        socket.connect({boost::asio::ip::make_address(address().host), address().port});
        return socket;
    }

    test::TemporaryFolder folder_;
    server::ServerOptions options_;
    std::unique_ptr<server::Server> server_;
    boost::asio::io_context io_;
};

TEST_F(ServerTest, SeveralClientsAtOnceGetTheirWholeModels) {
    const Bytes a = make_stream_file({.payload_bytes = 20'000}),
                b = make_stream_file({.payload_bytes = 9'000, .seed = 2});
    folder_.put("a.mvw", a);
    folder_.put("sub/b.mvw", b);
    start();
    std::vector<std::unique_ptr<Downloader>> clients;
    clients.reserve(6);
    for (int i = 0; i < 6; ++i)
        clients.push_back(std::make_unique<Downloader>(address(), i % 2 == 0 ? "a" : "sub/b.mvw"));
    for (int i = 0; i < 6; ++i) {
        ASSERT_TRUE(clients[i]->wait());
        clients[i]->expect_all_of(i % 2 == 0 ? a : b);
    }
    clients.clear();
    EXPECT_TRUE(connections_become(0)) << "a client that left is not forgotten";
}

TEST_F(ServerTest, RestartInMidStreamIsResumedWithoutAChunkTwice) {
    const Bytes file = make_stream_file(kLarge);
    folder_.put("a.mvw", file);
    start();
    const std::uint16_t port = address().port;
    Downloader client(address(), "a", {}, 5);
    ASSERT_TRUE(client.wait_for_pause());
    server_->stop();
    server_->wait();
    start(port);
    client.go_on();
    ASSERT_TRUE(client.wait());
    ASSERT_FALSE(client.failed) << client.failed->message;
    EXPECT_EQ(client.resumed, 1);
    client.expect_all_of(file);
}

TEST_F(ServerTest, FileReplacedInMidStreamComesOldToTheEnd) {
    const Bytes old_file = make_stream_file(kLarge);
    folder_.put("a.mvw", old_file);
    start();
    Downloader client(address(), "a", {}, 5);
    ASSERT_TRUE(client.wait_for_pause());
    const Bytes new_file = make_stream_file({.seed = 2});
    folder_.put("a.mvw", new_file);
    client.go_on();
    ASSERT_TRUE(client.wait());
    client.expect_all_of(old_file);
    Downloader next(address(), "a");
    ASSERT_TRUE(next.wait());
    next.expect_all_of(new_file);
}

TEST_F(ServerTest, FileOverwrittenInMidStreamIsBegunAnewAndNeverMixed) {
    folder_.put("a.mvw", make_stream_file(kLarge));
    start();
    Downloader client(address(), "a", {}, 5);
    ASSERT_TRUE(client.wait_for_pause());
    const Bytes new_file = make_stream_file({.seed = 2});
    folder_.overwrite("a.mvw", new_file);
    client.go_on();
    ASSERT_TRUE(client.wait());
    ASSERT_FALSE(client.failed) << client.failed->message;
    EXPECT_EQ(client.restarted, 1);
    client.expect_all_of(new_file);
}

TEST_F(ServerTest, SlowReaderDoesNotSlowAnother) {
    const Bytes file = make_stream_file(kLarge);
    folder_.put("a.mvw", file);
    options_.threads = 1;
    start();
    Downloader slow(address(), "a", {}, 1);
    ASSERT_TRUE(slow.wait_for_pause());
    Downloader quick(address(), "a");
    ASSERT_TRUE(quick.wait());
    quick.expect_all_of(file);
    EXPECT_FALSE(slow.satisfied);
    slow.go_on();
    ASSERT_TRUE(slow.wait());
    slow.expect_all_of(file);
}

TEST_F(ServerTest, ReaderThatStopsIsClosedInTheEnd) {
    folder_.put("a.mvw", make_stream_file(kLarge));
    options_.limits.stall_time = 200ms;
    start();
    tcp::socket socket = connect();
    protocol::Hello hello;
    hello.max_message_bytes = 1u << 28;
    boost::asio::write(socket, boost::asio::buffer(write_message(hello)));
    boost::asio::write(socket, boost::asio::buffer(write_message(protocol::Open{"a", "", {}, {}})));
    ASSERT_TRUE(connections_become(1));
    EXPECT_TRUE(connections_become(0));
}

TEST_F(ServerTest, NothingOutsideTheFolderIsServed) {
    folder_.put("secret.mvw", make_stream_file());
    folder_.put("served/a.mvw", make_stream_file());
    options_.folder = folder_.path("served");
    Result<std::unique_ptr<server::Server>> server = server::Server::start([&] {
        server::ServerOptions o = options_;
        o.tcp.port = o.http.port = 0;
        return o;
    }());
    ASSERT_TRUE(server.ok());
    for (const char* name : {"../secret", "/etc/passwd", "..", "a/../../secret", "./a", ""}) {
        Downloader client((*server)->tcp_address(), name);
        ASSERT_TRUE(client.wait());
        ASSERT_TRUE(client.failed) << name;
        EXPECT_NE(client.failed->message.find("no such model"), std::string::npos);
    }
}

TEST_F(ServerTest, ConnectionsOverTheLimitAreToldSoAndComeBackLater) {
    const Bytes file = make_stream_file();
    folder_.put("a.mvw", file);
    options_.limits.max_connections_per_address = 1;
    start();
    std::optional<tcp::socket> first(connect());
    ASSERT_TRUE(connections_become(1));
    tcp::socket second = connect();
    Bytes answer(64);
    boost::system::error_code error;
    const std::size_t n = boost::asio::read(second, boost::asio::buffer(answer), error);
    const Result<protocol::Parsed> message = protocol::read_message(ByteSpan(answer).first(n), {});
    ASSERT_TRUE(message.ok());
    EXPECT_EQ(std::get<protocol::ErrorMessage>(message->message).code, protocol::ErrorCode::TooBusy);

    Downloader client(address(), "a");
    std::this_thread::sleep_for(150ms);
    first.reset();
    ASSERT_TRUE(client.wait());
    client.expect_all_of(file);
}

TEST_F(ServerTest, MalformedBytesGetAnErrorThatArrivesBeforeTheEnd) {
    start();
    tcp::socket socket = connect();
    boost::asio::write(socket, boost::asio::buffer(std::string("GET / HTTP/1.1\r\nHost: a\r\n\r\n")));
    Bytes answer(200);
    boost::system::error_code error;
    const std::size_t n = boost::asio::read(socket, boost::asio::buffer(answer), error);
    EXPECT_EQ(error, boost::asio::error::eof) << error.message();
    const Result<protocol::Parsed> message = protocol::read_message(ByteSpan(answer).first(n), {});
    ASSERT_TRUE(message.ok());
    EXPECT_TRUE(std::holds_alternative<protocol::ErrorMessage>(message->message));
    socket.close();
    EXPECT_TRUE(connections_become(0));
}

TEST_F(ServerTest, DrainLetsStreamsEndAndClosesTheIdle) {
    const Bytes file = make_stream_file(kLarge);
    folder_.put("a.mvw", file);
    start();
    Downloader busy(address(), "a", {}, 3);
    ASSERT_TRUE(busy.wait_for_pause());
    tcp::socket idle = connect();
    ASSERT_TRUE(connections_become(2));
    server_->drain();
    EXPECT_TRUE(connections_become(1)) << "the idle one is still there";
    busy.go_on();
    ASSERT_TRUE(busy.wait());
    busy.expect_all_of(file);
    server_->wait();
    EXPECT_EQ(server_->connections(), 0u);
}

TEST_F(ServerTest, DrainLetsStreamsUnderTlsEndByTcpAndWebSocket) {
    const Bytes file = make_stream_file(kLarge);
    folder_.put("a.mvw", file);
    test::make_certificate(folder_.path("cert.pem"), folder_.path("key.pem"));
    options_.tls_cert = folder_.path("cert.pem");
    options_.tls_key = folder_.path("key.pem");
    start();
    const auto tls = client::make_client_tls(options_.tls_cert).value();
    Downloader by_tcp(client::Url{client::Scheme::Tcp, address(), "a", true, {}}, {}, 3, tls.get());
    Downloader by_web(client::Url{client::Scheme::WebSocket, server_->http_address(), "a", true, {}}, {}, 3, tls.get());
    ASSERT_TRUE(by_tcp.wait_for_pause());
    ASSERT_TRUE(by_web.wait_for_pause());
    server_->drain();
    by_tcp.go_on();
    by_web.go_on();
    for (Downloader* client : {&by_tcp, &by_web}) {
        ASSERT_TRUE(client->wait());
        ASSERT_FALSE(client->failed) << client->failed->message;
        EXPECT_EQ(client->resumed, 0);
        client->expect_all_of(file);
    }
    const auto begin = std::chrono::steady_clock::now();
    server_->wait();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
}

TEST_F(ServerTest, DrainEndsInTimeEvenIfAStreamDoesNot) {
    folder_.put("a.mvw", make_stream_file(kLarge));
    options_.limits.drain_time = 100ms;
    start();
    Downloader stuck(address(), "a", {}, 3);
    ASSERT_TRUE(stuck.wait_for_pause());
    const auto begin = std::chrono::steady_clock::now();
    server_->drain();
    server_->wait();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
}

TEST_F(ServerTest, AddressInUseAndMissingFolderAreErrors) {
    start();
    server::ServerOptions second = options_;
    second.tcp = address();
    EXPECT_EQ(server::Server::start(second).error().code, Errc::Io);
    second.tcp.port = second.http.port = 0;
    second.folder = folder_.path("none");
    EXPECT_EQ(server::Server::start(second).error().code, Errc::Io);
}

TEST_F(ServerTest, RandomBytesOverTheWireLeaveItServing) {
    const Bytes file = make_stream_file();
    folder_.put("a.mvw", file);
    start();
    unsigned random = 1;
    for (int round = 0; round < 50; ++round) {
        tcp::socket socket = connect();
        Bytes noise(300);
        for (std::byte& b : noise) b = static_cast<std::byte>((random = random * 1664525u + 1013904223u) >> 24);
        if (round % 2 == 0) noise[0] = noise[1] = noise[2] = noise[3] = std::byte{0};
        boost::system::error_code ignored;
        boost::asio::write(socket, boost::asio::buffer(noise), ignored);
    }
    EXPECT_TRUE(connections_become(0));
    Downloader client(address(), "a");
    ASSERT_TRUE(client.wait());
    client.expect_all_of(file);
}

}  // namespace
}  // namespace mvw
