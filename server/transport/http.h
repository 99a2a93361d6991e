// HTTP/1.1 connections: reads requests, sends what the site answers, and hands WebSocket upgrades on to peer.h. One of
// the two files that see Beast.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "server/site.h"
#include "server/transport/listener.h"

namespace mvw::server {

/// Where WebSocket is to be found.
inline constexpr const char* kStreamPath = "/stream";

/// A connection that speaks HTTP over `carrier`. `context` and `site` outlive it.
std::shared_ptr<Connection> make_http(std::unique_ptr<Carrier> carrier, const PeerContext& context, const Site& site,
                                      std::string name, std::function<void()> on_end);

}  // namespace mvw::server
