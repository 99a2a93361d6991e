// The program itself, as a process that is killed, restarted and run behind others.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <utility>  // before Asio, which uses std::exchange without it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

#include <chrono>
#include <filesystem>
#include <thread>

#include "codec/encoder.h"
#include "tests/support/downloader.h"
#include "tests/support/program.h"
#include "tests/support/shapes.h"
#include "tools/bench/process.h"

namespace mvw {
namespace {

using bench::BackgroundProcess;
using test::Downloader;
using test::make_stream_file;

// Larger than what the sockets' buffers take: a client that does not read holds the server up.
const test::StreamModelShape kLarge{.tiles = 4, .levels = 3, .layers = 4, .payload_bytes = 400'000};

/// mvw serve of a folder on ports of the system's choice, or on given ones.
class Served {
 public:
    explicit Served(const std::string& folder, std::uint16_t tcp_port = 0, std::uint16_t http_port = 0,
                    const std::vector<std::string>& more = {})
        : process_(BackgroundProcess::start(command(folder, tcp_port, http_port, more)).value()) {
        const std::string line = process_.first_line(20);
        tcp = port_after(line, "mvw://");
        http = port_after(line, "http://");
    }
    void kill_it() const { ::kill(process_.pid(), SIGKILL); }
    [[nodiscard]] protocol::HostPort tcp_address() const { return {"127.0.0.1", tcp}; }
    [[nodiscard]] protocol::HostPort http_address() const { return {"127.0.0.1", http}; }

    std::uint16_t tcp = 0, http = 0;

 private:
    static std::vector<std::string> command(const std::string& folder, std::uint16_t tcp_port, std::uint16_t http_port,
                                            const std::vector<std::string>& more) {
        std::vector<std::string> words{mvw_program(),
                                       "serve",
                                       folder,
                                       "--tcp",
                                       "127.0.0.1:" + std::to_string(tcp_port),
                                       "--http",
                                       "127.0.0.1:" + std::to_string(http_port)};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    static std::uint16_t port_after(const std::string& line, const std::string& scheme) {
        const std::size_t at = line.find(scheme);
        if (at == std::string::npos) throw std::runtime_error("mvw serve does not start: " + line);
        return static_cast<std::uint16_t>(std::stoi(line.substr(line.find(':', at + scheme.size()) + 1)));
    }
    BackgroundProcess process_;
};

client::Url url_of(client::Scheme scheme, const Served& server) {
    return {scheme, scheme == client::Scheme::Tcp ? server.tcp_address() : server.http_address(), "a", false, {}};
}

class ProgramTest : public testing::TestWithParam<client::Scheme> {
 protected:
    test::TemporaryFolder folder_;
};

TEST_P(ProgramTest, KilledAndRestartedInMidStreamNothingIsLostOrSentTwice) {
    const Bytes file = make_stream_file(kLarge);
    folder_.put("a.mvw", file);
    auto first = std::make_unique<Served>(folder_.path());
    Downloader client(url_of(GetParam(), *first), {}, 5);
    ASSERT_TRUE(client.wait_for_pause());
    const std::uint16_t tcp = first->tcp, http = first->http;
    first->kill_it();
    first.reset();
    const Served second(folder_.path(), tcp, http);
    client.go_on();
    ASSERT_TRUE(client.wait());
    ASSERT_FALSE(client.failed) << client.failed->message;
    EXPECT_EQ(client.resumed, 1);
    client.expect_all_of(file);
}

TEST_P(ProgramTest, KilledAndRestartedWithAnotherFileIsBegunAnewAndNeverMixed) {
    folder_.put("a.mvw", make_stream_file(kLarge));
    auto first = std::make_unique<Served>(folder_.path());
    Downloader client(url_of(GetParam(), *first), {}, 5);
    ASSERT_TRUE(client.wait_for_pause());
    const std::uint16_t tcp = first->tcp, http = first->http;
    first->kill_it();
    first.reset();
    const Bytes fresh = make_stream_file({.seed = 2});
    folder_.put("a.mvw", fresh);
    const Served second(folder_.path(), tcp, http);
    client.go_on();
    ASSERT_TRUE(client.wait());
    ASSERT_FALSE(client.failed) << client.failed->message;
    EXPECT_EQ(client.restarted, 1);
    client.expect_all_of(fresh);
}

INSTANTIATE_TEST_SUITE_P(Ways, ProgramTest, testing::Values(client::Scheme::Tcp, client::Scheme::WebSocket));

// --- Behind other programs: skipped, and counted as such, where they are not installed. ---

bool have(const std::string& program) {
    for (const char* folder : {"/usr/sbin/", "/usr/bin/", "/usr/local/sbin/", "/usr/local/bin/"})
        if (std::filesystem::exists(folder + program)) return true;
    return false;
}

std::string deploy_file(const std::string& name) {
    return read_text(test_data_folder() + "/../../server/deploy/" + name);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    EXPECT_NE(text.find(from), std::string::npos) << from;
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
        text.replace(at, from.size(), to);
    return text;
}

/// A port that nobody listens on now.
std::uint16_t free_port() {
    boost::asio::io_context io;
    boost::asio::ip::tcp::acceptor acceptor(io, {boost::asio::ip::address_v4::loopback(), 0});
    return acceptor.local_endpoint().port();
}

bool answers(std::uint16_t port) {
    for (int i = 0; i < 300; ++i) {
        boost::asio::io_context io;
        boost::asio::ip::tcp::socket socket(io);
        boost::system::error_code error;
        socket.connect({boost::asio::ip::address_v4::loopback(), port}, error);
        if (!error) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
}

// The real model through an address; empty where it came byte for byte, else what went wrong.
std::string fetch_same(const std::string& url, const std::string& served) {
    const ScratchFolder folder;
    const ProgramRun run = run_mvw({"fetch", url, folder / "out.mvw"});
    if (run.exit_code != 0) return run.errors;
    return read_text(folder / "out.mvw") == read_text(served) ? "" : "other bytes came";
}

class DeployTest : public testing::Test {
 protected:
    void put_model() const {
        EncodeOptions options;
        options.threads = 1;
        const Result<Encoded> encoded = encode(torus(48, 24), options);
        ASSERT_TRUE(encoded.ok());
        folder_.put("a.mvw", encoded->file);
    }
    // server/deploy/nginx.conf, serving the test's folder on a port of the loopback.
    Result<BackgroundProcess> start_nginx(std::uint16_t port) const {
        std::string conf = replaced(deploy_file("nginx.conf"), "/srv/mvw/", folder_.path() + "/");
        conf = replaced(conf, "listen 80;", "listen 127.0.0.1:" + std::to_string(port) + ";");
        conf = replaced(conf, "http {\n",
                        "http {\n client_body_temp_path " + (scratch_ / "b") + "; proxy_temp_path " + (scratch_ / "p") +
                            "; fastcgi_temp_path " + (scratch_ / "f") + "; uwsgi_temp_path " + (scratch_ / "u") +
                            "; scgi_temp_path " + (scratch_ / "s") + ";\n");
        write_text(scratch_ / "nginx.conf", conf);
        std::string globals = "daemon off; pid " + (scratch_ / "pid") + "; error_log stderr;";
        if (::geteuid() == 0) globals += " user root;";  // the test's folders are its own
        return BackgroundProcess::start(
            {"/usr/sbin/nginx", "-p", scratch_ / "", "-e", "stderr", "-c", scratch_ / "nginx.conf", "-g", globals});
    }

    test::TemporaryFolder folder_;
    ScratchFolder scratch_;
};

TEST_F(DeployTest, NginxServesStaticFiles) {
    if (!have("nginx")) GTEST_SKIP() << "nginx is not installed";
    put_model();
    const std::uint16_t port = free_port();
    const auto nginx = start_nginx(port);
    ASSERT_TRUE(nginx.ok());
    ASSERT_TRUE(answers(port));
    const std::string url = "http://127.0.0.1:" + std::to_string(port) + "/models/a.mvw";
    EXPECT_EQ(fetch_same(url, folder_.path("a.mvw")), "");
    EXPECT_EQ(fetch_same(url + "?v=1", folder_.path("a.mvw")), "");
    const ProgramRun coarse = run_mvw({"fetch", url, scratch_ / "coarse.ply", "--level", "0", "--json"});
    EXPECT_EQ(coarse.exit_code, 0) << coarse.errors;
}

TEST_F(DeployTest, NginxIsTheStoreBehindMvwServe) {
    if (!have("nginx")) GTEST_SKIP() << "nginx is not installed";
    put_model();
    const std::uint16_t port = free_port();
    std::optional<Result<BackgroundProcess>> nginx(start_nginx(port));
    ASSERT_TRUE(nginx->ok());
    ASSERT_TRUE(answers(port));
    const test::TemporaryFolder cache;
    const std::string origin = "http://127.0.0.1:" + std::to_string(port) + "/models";
    auto server = std::make_unique<Served>(cache.path(), 0, 0, std::vector<std::string>{"--origin", origin});
    const std::string served = folder_.path("a.mvw");
    EXPECT_EQ(fetch_same("mvw://" + to_string(server->tcp_address()) + "/a", served), "");
    EXPECT_EQ(fetch_same("ws://" + to_string(server->http_address()) + "/a", served), "");
    EXPECT_EQ(fetch_same("http://" + to_string(server->http_address()) + "/models/a.mvw", served), "");
    // Killed, and without nginx: what is on the disk is served on.
    const std::uint16_t tcp = server->tcp, http = server->http;
    server->kill_it();
    server.reset();
    const Served again(cache.path(), tcp, http, {"--origin", origin});
    EXPECT_EQ(fetch_same("mvw://" + to_string(again.tcp_address()) + "/a", served), "");
    nginx.reset();
    EXPECT_EQ(fetch_same("mvw://" + to_string(again.tcp_address()) + "/a", served), "");
}

TEST_F(DeployTest, VarnishKeepsWhatMvwServes) {
    if (!have("varnishd")) GTEST_SKIP() << "varnish is not installed";
    put_model();
    const Served server(folder_.path());
    std::string vcl = replaced(deploy_file("varnish.vcl"), "10.0.0.11", "127.0.0.1");
    vcl = replaced(vcl, "\"8080\"", "\"" + std::to_string(server.http) + "\"");
    write_text(scratch_ / "varnish.vcl", vcl);
    const std::uint16_t port = free_port();
    const auto varnish = BackgroundProcess::start({"/usr/sbin/varnishd", "-F", "-j", "none", "-n", scratch_ / "work",
                                                   "-a", "127.0.0.1:" + std::to_string(port), "-f",
                                                   scratch_ / "varnish.vcl", "-s", "malloc,32m"});
    ASSERT_TRUE(varnish.ok());
    ASSERT_TRUE(answers(port));
    const std::string base = "127.0.0.1:" + std::to_string(port);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(fetch_same("http://" + base + "/models/a.mvw", folder_.path("a.mvw")), "");
        const ProgramRun part =
            run_mvw({"fetch", "http://" + base + "/models/a.mvw", scratch_ / "a.ply", "--level", "0"});
        EXPECT_EQ(part.exit_code, 0) << part.errors;
    }
    EXPECT_EQ(fetch_same("ws://" + base + "/a", folder_.path("a.mvw")), "");
}

TEST_F(DeployTest, BackendBehindHaproxyKilledInMidStreamDoesTheClientNoHarm) {
    if (!have("haproxy")) GTEST_SKIP() << "haproxy is not installed";
    const Bytes file = make_stream_file(kLarge);
    folder_.put("a.mvw", file);
    const Served a(folder_.path()), b(folder_.path());
    const std::uint16_t tcp = free_port(), http = free_port();
    std::string conf = deploy_file("haproxy.cfg");
    conf = replaced(conf, "bind :7707", "bind 127.0.0.1:" + std::to_string(tcp));
    conf = replaced(conf, "bind :8080", "bind 127.0.0.1:" + std::to_string(http));
    const auto at = [](std::uint16_t port) { return "127.0.0.1:" + std::to_string(port); };
    conf = replaced(conf, "10.0.0.11:7707 check port 8080", at(a.tcp) + " check port " + std::to_string(a.http));
    conf = replaced(conf, "10.0.0.12:7707 check port 8080", at(b.tcp) + " check port " + std::to_string(b.http));
    conf = replaced(conf, "10.0.0.11:8080", at(a.http));
    conf = replaced(conf, "10.0.0.12:8080", at(b.http));
    write_text(scratch_ / "haproxy.cfg", conf);
    const auto haproxy = BackgroundProcess::start({"/usr/sbin/haproxy", "-db", "-f", scratch_ / "haproxy.cfg"});
    ASSERT_TRUE(haproxy.ok());
    ASSERT_TRUE(answers(tcp));
    for (const client::Scheme scheme : {client::Scheme::Tcp, client::Scheme::WebSocket}) {
        const protocol::HostPort address{"127.0.0.1", scheme == client::Scheme::Tcp ? tcp : http};
        const client::Url url{scheme, address, "a", false, {}};
        Downloader first(url, {}, 5), second(url, {}, 5);  // one on each server, by leastconn
        ASSERT_TRUE(first.wait_for_pause());
        ASSERT_TRUE(second.wait_for_pause());
        if (scheme == client::Scheme::Tcp) a.kill_it();
        first.go_on();
        second.go_on();
        ASSERT_TRUE(first.wait());
        ASSERT_TRUE(second.wait());
        ASSERT_FALSE(first.failed) << first.failed->message;
        ASSERT_FALSE(second.failed) << second.failed->message;
        first.expect_all_of(file);
        second.expect_all_of(file);
        EXPECT_EQ(first.resumed + second.resumed, scheme == client::Scheme::Tcp ? 1 : 0);
    }
}

}  // namespace
}  // namespace mvw
