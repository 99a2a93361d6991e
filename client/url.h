// Where a model is: SCHEME://HOST[:PORT]/MODEL, or any http address of a .mvw file.
#pragma once
#include <string>
#include <string_view>

#include "server/protocol/address.h"

namespace mvw::client {

enum class Scheme {
    Tcp,        // mvw://, mvws://
    WebSocket,  // ws://, wss://
    Http,       // http://, https://
};

struct Url {
    Scheme scheme = Scheme::Tcp;
    protocol::HostPort address;
    std::string model;     // %XX decoded; with or without ".mvw"
    bool tls = false;      // mvws://, wss://, https://
    std::string target{};  // Http: what follows host and port, as written ("/models/bunny.mvw?v=1")
};

/// Ports where the URL has none: 7707 for mvw and mvws, 80 for ws and http, 443 for wss and https.
/// InvalidArgument with a sentence where the text is not such a URL; Unsupported for another scheme.
Result<Url> parse_url(std::string_view text);

}  // namespace mvw::client
