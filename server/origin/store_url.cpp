#include "server/origin/store_url.h"

#include <algorithm>

#include "server/protocol/percent.h"

namespace mvw::server {

Result<StoreUrl> parse_store_url(std::string_view text) {
    const auto bad = [&](const char* why) {
        return Error{Errc::InvalidArgument, 0, "\"" + std::string(text) + "\": " + why};
    };
    constexpr std::string_view kPlain = "http://", kSecure = "https://";
    StoreUrl url;
    url.tls = text.starts_with(kSecure);
    if (!url.tls && !text.starts_with(kPlain)) return bad("not an http or https URL");
    const bool odd = std::any_of(text.begin(), text.end(), [](char c) { return c <= ' ' || c == '#' || c == '\x7F'; });
    if (odd) return bad("blanks, control characters and '#' have no place in it");
    const std::string_view rest = text.substr(url.tls ? kSecure.size() : kPlain.size());
    const std::size_t end = std::min(rest.find_first_of("/?"), rest.size());
    Result<protocol::HostPort> address = protocol::parse_host_port(rest.substr(0, end), url.tls ? 443 : 80);
    if (!address) return address.error();
    if (address->port == 0) return bad("port 0 cannot be connected to");
    url.address = std::move(address).value();
    url.target = rest.substr(end);
    if (!url.target.starts_with('/')) url.target.insert(0, "/");
    return url;
}

StoreUrl url_below(const StoreUrl& base, std::string_view name) {
    const std::size_t query = std::min(base.target.find('?'), base.target.size());
    std::string path = base.target.substr(0, query);
    if (!path.ends_with('/')) path += '/';
    StoreUrl url = base;
    url.target = path + protocol::percent_encode(name) + ".mvw" + base.target.substr(query);
    return url;
}

}  // namespace mvw::server
