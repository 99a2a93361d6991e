#include "server/protocol/address.h"

#include <charconv>

namespace mvw::protocol {

Result<HostPort> parse_host_port(std::string_view text, std::uint16_t default_port) {
    const auto bad = [&](const char* why) {
        return Error{Errc::InvalidArgument, 0, "\"" + std::string(text) + "\": " + why};
    };
    HostPort address{"", default_port};
    std::string_view rest;
    if (text.starts_with('[')) {
        const std::size_t end = text.find(']');
        if (end == std::string_view::npos) return bad("the bracket is not closed");
        address.host = text.substr(1, end - 1);
        rest = text.substr(end + 1);
    } else {
        const std::size_t colon = text.find(':');
        address.host = text.substr(0, colon);
        rest = colon == std::string_view::npos ? std::string_view{} : text.substr(colon);
        if (rest.find(':', 1) != std::string_view::npos) return bad("an IPv6 address needs brackets");
    }
    if (address.host.empty()) return bad("no host");
    if (rest.empty()) return address;
    const char* end = rest.data() + rest.size();
    const auto [stop, error] = std::from_chars(rest.data() + 1, end, address.port);
    if (rest[0] != ':' || error != std::errc{} || stop != end) return bad("the port is not a number from 0 to 65535");
    return address;
}

std::string to_string(const HostPort& address) {
    const bool ipv6 = address.host.find(':') != std::string::npos;
    return (ipv6 ? "[" + address.host + "]" : address.host) + ":" + std::to_string(address.port);
}

}  // namespace mvw::protocol
