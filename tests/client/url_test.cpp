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

TEST(Url, RefusesWhatItCannotFetch) {
    for (const char* bad : {"", "bunny", "mvw:/a/b", "mvw://", "mvw://host", "mvw://host/", "mvw:///model",
                            "mvw://h:x/m", "mvw://h:0/m", "mvw://h/%", "mvw://h/%2", "mvw://h/%zz"})
        EXPECT_EQ(parse_url(bad).error().code, Errc::InvalidArgument) << bad;
    EXPECT_EQ(parse_url("ftp://host/model").error().code, Errc::Unsupported);
    EXPECT_FALSE(parse_url("mvw://h/" + std::string(2000, 'a')).ok());
}

}  // namespace
}  // namespace mvw::client
