// WebSocket (RFC 6455) as a carrier: binary messages whose bytes are one row. One of the two files that see Beast.
#pragma once
#include <memory>
#include <string>

#include "server/limits.h"
#include "server/transport/carrier.h"

namespace mvw::server {

/// The name of the native protocol within WebSocket's own greeting.
inline constexpr const char* kSubprotocol = "mvw.1";

/// What of the upgrade request counts.
struct UpgradeRequest {
    std::string target, host, key, version, protocols;  // fields as sent
};

/// A carrier over `below`, whose request head has been read and nothing behind it; its handshake() answers the upgrade.
std::unique_ptr<Carrier> upgrade(std::unique_ptr<Carrier> below, UpgradeRequest request, const ServerLimits& limits);

}  // namespace mvw::server
