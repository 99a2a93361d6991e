// Carries one session of the native protocol: moves bytes, keeps the session's timer, applies backpressure, nothing
// else.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "server/transport/listener.h"

namespace mvw::server {

/// A connection that speaks the native protocol over `carrier`. `context` outlives it.
std::shared_ptr<Connection> make_peer(std::unique_ptr<Carrier> carrier, Way way, const PeerContext& context,
                                      std::string name, std::function<void()> on_end);

}  // namespace mvw::server
