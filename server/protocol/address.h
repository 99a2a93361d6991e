// HOST:PORT, as given on command lines and in URLs.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "codec/result.h"

namespace mvw::protocol {

inline constexpr std::uint16_t kDefaultPort = 7707;
inline constexpr std::uint16_t kDefaultHttpPort = 8080;

struct HostPort {
    std::string host;  // a name, an IPv4 address, or an IPv6 address without its brackets
    std::uint16_t port = kDefaultPort;
    friend bool operator==(const HostPort&, const HostPort&) = default;
};

/// "host", "host:port", "[ipv6]" or "[ipv6]:port". InvalidArgument with a sentence otherwise.
Result<HostPort> parse_host_port(std::string_view text, std::uint16_t default_port = kDefaultPort);
/// The other way round; the port is always written.
std::string to_string(const HostPort& address);

}  // namespace mvw::protocol
