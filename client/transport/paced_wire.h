// A wire that is read no faster than somebody wants. Inside the transport folder only.
#pragma once
#include "client/pace.h"
#include "client/transport/wire.h"

namespace mvw::client {

/// The wire itself where there is no pace.
std::unique_ptr<Wire> at_pace(asio::io_context& io, std::unique_ptr<Wire> wire, const PacePtr& pace);

}  // namespace mvw::client
