#include "client/url.h"

#include <gtest/gtest.h>

namespace mvw::client {
namespace {

TEST(Url, ReadsHostPortAndModel) {
    const Url url = parse_url("mvw://example.org:99/scans/a%20b.mvw").value();
    EXPECT_EQ(url.address, (protocol::HostPort{"example.org", 99}));
    EXPECT_EQ(url.model, "scans/a b.mvw");
    EXPECT_EQ(parse_url("mvw://[::1]/m").value().address, (protocol::HostPort{"::1", protocol::kDefaultPort}));
}

TEST(Url, SchemesTellTransportTlsAndPort) {
    const Url ws = parse_url("wss://h/scans/a").value();
    EXPECT_EQ(ws.scheme, Scheme::WebSocket);
    EXPECT_TRUE(ws.tls);
    EXPECT_EQ(ws.address.port, 443);
    EXPECT_EQ(parse_url("ws://h/a").value().address.port, 80);
    EXPECT_TRUE(parse_url("mvws://h/a").value().tls);
    const Url http = parse_url("http://h:8080/models/a%20b.mvw?v=1&x=%zz").value();
    EXPECT_EQ(http.scheme, Scheme::Http);
    EXPECT_EQ(http.target, "/models/a%20b.mvw?v=1&x=%zz");
    EXPECT_EQ(http.model, "models/a b.mvw");
}

TEST(Url, RefusesWhatItCannotFetch) {
    for (const char* bad :
         {"", "bunny", "mvw:/a/b", "mvw://", "mvw://host", "mvw://host/", "mvw:///model", "mvw://h:x/m", "mvw://h:0/m",
          "mvw://h/%", "mvw://h/%2", "mvw://h/%zz", "http://h/a b", "http://h/a\r\nX: y", "http://h/a#b"})
        EXPECT_EQ(parse_url(bad).error().code, Errc::InvalidArgument) << bad;
    EXPECT_EQ(parse_url("ftp://host/model").error().code, Errc::Unsupported);
    EXPECT_FALSE(parse_url("mvw://h/" + std::string(2000, 'a')).ok());
}

}  // namespace
}  // namespace mvw::client
