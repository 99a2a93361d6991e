// HTTP over real sockets: what the parser, the timers and the limits do to well and badly meaning peers.
#include <gtest/gtest.h>

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>

#include <thread>

#include "server/server.h"
#include "tests/support/program.h"
#include "tests/support/stream_models.h"

namespace mvw {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using test::make_stream_file;

class HttpTest : public testing::Test {
 protected:
    void start() {
        options_.folder = folder_.path();
        options_.tcp.port = options_.http.port = 0;
        Result<std::unique_ptr<server::Server>> server = server::Server::start(options_);
        ASSERT_TRUE(server.ok()) << server.error().message;
        server_ = std::move(server).value();
    }
    tcp::socket connect() {
        tcp::socket socket(io_);
        socket.connect({boost::asio::ip::make_address("127.0.0.1"), server_->http_address().port});
        return socket;
    }
    static void send(tcp::socket& socket, const std::string& text) {
        boost::system::error_code ignored;
        boost::asio::write(socket, boost::asio::buffer(text), ignored);
    }
    // All that comes until the server ends the connection.
    static std::string read_to_end(tcp::socket& socket) {
        std::string all;
        boost::system::error_code error;
        boost::asio::read(socket, boost::asio::dynamic_buffer(all), error);
        return all;
    }
    std::string ask(const std::string& text) {
        tcp::socket socket = connect();
        send(socket, text);
        return read_to_end(socket);
    }
    static std::string get(const std::string& path, const std::string& more = "") {
        return "GET " + path + " HTTP/1.1\r\nHost: h\r\n" + more + "\r\n";
    }
    bool connections_become(std::size_t n) {
        for (int i = 0; i < 500 && server_->connections() != n; ++i) std::this_thread::sleep_for(10ms);
        return server_->connections() == n;
    }
    std::string metric(const std::string& name) {
        const std::string text = ask(get("/metrics", "Connection: close\r\n"));
        const std::size_t at = text.find("\n" + name + " ");
        return at == std::string::npos
                   ? "none"
                   : text.substr(at + name.size() + 2, text.find('\n', at + 1) - at - name.size() - 2);
    }

    test::TemporaryFolder folder_;
    server::ServerOptions options_;
    std::unique_ptr<server::Server> server_;
    boost::asio::io_context io_;
};

TEST_F(HttpTest, LargeFileComesWholeAndInParts) {
    const Bytes file = make_stream_file({.payload_bytes = 60'000});
    const std::string text(reinterpret_cast<const char*>(file.data()), file.size());
    folder_.put("a.mvw", file);
    start();
    const std::string whole = ask(get("/models/a.mvw", "Connection: close\r\n"));
    ASSERT_GT(whole.size(), text.size());
    EXPECT_TRUE(whole.substr(whole.size() - text.size()) == text);
    const std::string part = ask(get("/models/a.mvw", "Connection: close\r\nRange: bytes=1000-2000000\r\n"));
    EXPECT_TRUE(part.starts_with("HTTP/1.1 206"));
    EXPECT_TRUE(part.ends_with(text.substr(1000, 1'999'001)));
}

TEST_F(HttpTest, RequestsMayFollowEachOtherWithoutWaiting) {
    start();
    const std::string answers = ask(get("/healthz") + get("/nothing") + get("/healthz", "Connection: close\r\n"));
    EXPECT_TRUE(answers.starts_with("HTTP/1.1 200"));
    EXPECT_NE(answers.find("HTTP/1.1 404"), std::string::npos);
    EXPECT_NE(answers.rfind("HTTP/1.1 200"), 0u);
}

TEST_F(HttpTest, HeadersAByteAtATimeAreReadAndSlowOnesAreNot) {
    options_.limits.header_time = 300ms;
    start();
    tcp::socket quick = connect();
    for (const char c : get("/healthz", "Connection: close\r\n")) send(quick, std::string(1, c));
    EXPECT_TRUE(read_to_end(quick).starts_with("HTTP/1.1 200"));

    tcp::socket slow = connect();
    const auto begin = std::chrono::steady_clock::now();
    std::thread drip([&] {
        const std::string text = get("/healthz");
        for (int i = 0; i < 40; ++i) {
            send(slow, text.substr(i % 20, 1));
            std::this_thread::sleep_for(50ms);
        }
    });
    const std::string answer = read_to_end(slow);
    const auto took = std::chrono::steady_clock::now() - begin;
    drip.join();
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 408")) << answer;
    EXPECT_GT(took, 250ms);
    EXPECT_LT(took, 2s);
    slow.close();
    EXPECT_EQ(metric("mvw_timeouts_total"), "1");
}

TEST_F(HttpTest, OversizedAndMalformedRequestsAreRefusedAndCounted) {
    start();
    EXPECT_TRUE(ask(get("/healthz", "X: " + std::string(10'000, 'a') + "\r\n")).starts_with("HTTP/1.1 431"));
    EXPECT_TRUE(ask("\x16\x03\x01 not HTTP\r\n\r\n").starts_with("HTTP/1.1 400"));
    EXPECT_TRUE(ask("GET / HTTP/3.0\r\n\r\n").starts_with("HTTP/1.1 400"));
    EXPECT_TRUE(ask("POST / HTTP/1.1\r\nHost: h\r\nContent-Length: 3\r\n\r\nabc").starts_with("HTTP/1.1 413"));
    EXPECT_TRUE(ask("POST / HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n").starts_with("HTTP/1.1 405"));
    EXPECT_TRUE(ask(get("/stream")).starts_with("HTTP/1.1 426"));
    EXPECT_EQ(metric("mvw_malformed_total"), "3");
}

TEST_F(HttpTest, TooManyRequestsASecondAreToldSo) {
    options_.limits.message_burst = 3;
    options_.limits.messages_per_second = 0.1;
    start();
    std::string many;
    for (int i = 0; i < 5; ++i) many += get("/healthz");
    const std::string answers = ask(many);
    EXPECT_NE(answers.find("HTTP/1.1 429"), std::string::npos);
    EXPECT_NE(answers.find("Retry-After: 1"), std::string::npos);
}

TEST_F(HttpTest, ReaderThatStopsIsClosedInTheEnd) {
    folder_.put("a.mvw", make_stream_file({.payload_bytes = 400'000}));
    options_.limits.stall_time = 200ms;
    start();
    tcp::socket socket = connect();
    send(socket, get("/models/a.mvw"));
    ASSERT_TRUE(connections_become(1));
    EXPECT_TRUE(connections_become(0));
}

TEST_F(HttpTest, IdleConnectionIsClosed) {
    options_.limits.http_idle_time = 100ms;
    start();
    tcp::socket socket = connect();
    send(socket, get("/healthz"));
    EXPECT_TRUE(read_to_end(socket).starts_with("HTTP/1.1 200"));
    EXPECT_TRUE(connections_become(0));
}

TEST_F(HttpTest, FileOverwrittenWhileItIsSentEndsShort) {
    const Bytes file = make_stream_file({.payload_bytes = 400'000});
    folder_.put("a.mvw", file);
    start();
    tcp::socket socket = connect();
    send(socket, get("/models/a.mvw"));
    std::string head(1000, ' ');
    boost::asio::read(socket, boost::asio::buffer(head));
    folder_.overwrite("a.mvw", make_stream_file({.payload_bytes = 400'000, .seed = 2}));
    const std::string rest = read_to_end(socket);
    EXPECT_LT(head.size() + rest.size(), file.size());
}

TEST_F(HttpTest, PeersThatVanishInMidAnswerAreSurvived) {
    folder_.put("a.mvw", make_stream_file({.payload_bytes = 100'000}));
    start();
    for (int i = 0; i < 20; ++i) {
        tcp::socket socket = connect();
        send(socket, get("/models/a.mvw"));
        std::string text(100, ' ');
        boost::asio::read(socket, boost::asio::buffer(text));
        socket.set_option(boost::asio::socket_base::linger(true, 0));
    }
    EXPECT_TRUE(connections_become(0));
    EXPECT_TRUE(ask(get("/healthz", "Connection: close\r\n")).starts_with("HTTP/1.1 200"));
}

TEST_F(HttpTest, DrainFinishesTheAnswerAndClosesTheIdle) {
    const Bytes file = make_stream_file({.payload_bytes = 400'000});
    folder_.put("a.mvw", file);
    start();
    tcp::socket idle = connect(), busy = connect();
    send(idle, get("/healthz"));
    std::string text(12, ' ');
    boost::asio::read(idle, boost::asio::buffer(text));
    send(busy, get("/models/a.mvw"));
    boost::asio::read(busy, boost::asio::buffer(text));
    server_->drain();
    read_to_end(idle);
    EXPECT_GT(read_to_end(busy).size(), file.size());
    server_->wait();
    EXPECT_EQ(server_->connections(), 0u);
}

TEST_F(HttpTest, ConnectionsOverTheLimitAreToldSo) {
    options_.limits.max_connections_per_address = 1;
    start();
    tcp::socket first = connect();
    ASSERT_TRUE(connections_become(1));
    tcp::socket second = connect();
    EXPECT_TRUE(read_to_end(second).starts_with("HTTP/1.1 503"));
}

TEST_F(HttpTest, RandomBytesLeaveItServing) {
    start();
    unsigned random = 1;
    for (int round = 0; round < 50; ++round) {
        tcp::socket socket = connect();
        std::string noise(300, ' ');
        for (char& c : noise) c = static_cast<char>((random = random * 1664525u + 1013904223u) >> 24);
        if (round % 2 == 0) {
            noise.insert(0, "GET /stream HTTP/1.1\r\nConnection: upgrade\r\nUpgrade: websocket\r\n");
            noise += "\r\n\r\n";
        }
        send(socket, noise);
    }
    EXPECT_TRUE(connections_become(0));
    EXPECT_TRUE(ask(get("/healthz", "Connection: close\r\n")).starts_with("HTTP/1.1 200"));
}

}  // namespace
}  // namespace mvw
