#include "server/origin/store_url.h"

#include <gtest/gtest.h>

namespace mvw::server {
namespace {

TEST(StoreUrl, ReadsHostPortPathAndQuery) {
    const StoreUrl url = parse_store_url("https://store.example/bucket/scans?X-Sig=a%2Fb").value();
    EXPECT_TRUE(url.tls);
    EXPECT_EQ(url.address, (protocol::HostPort{"store.example", 443}));
    EXPECT_EQ(url.target, "/bucket/scans?X-Sig=a%2Fb");
    EXPECT_EQ(parse_store_url("http://[::1]:9000").value().target, "/");
    EXPECT_EQ(parse_store_url("http://a?b=c").value().target, "/?b=c");
}

TEST(StoreUrl, RefusesWhatCouldNotBeAsked) {
    for (const char* text : {"", "store", "ftp://a/b", "http://", "http:///b", "http://a:0/b", "http://a:99999/b",
                             "http://a/b c", "http://a/b\r\nHost: x", "http://a/b#c"})
        EXPECT_EQ(parse_store_url(text).error().code, Errc::InvalidArgument) << text;
}

TEST(StoreUrl, ModelsAreBelowItWithItsQueryBehind) {
    const StoreUrl base = parse_store_url("http://a/bucket?sas=1").value();
    EXPECT_EQ(url_below(base, "sub dir/b").target, "/bucket/sub%20dir/b.mvw?sas=1");
    EXPECT_EQ(url_below(parse_store_url("http://a/bucket/").value(), "b").target, "/bucket/b.mvw");
    EXPECT_EQ(url_below(parse_store_url("http://a").value(), "b").target, "/b.mvw");
}

}  // namespace
}  // namespace mvw::server
