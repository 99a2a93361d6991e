// Where a model is: SCHEME://HOST[:PORT]/MODEL.
#pragma once
#include <string>
#include <string_view>

#include "server/protocol/address.h"

namespace mvw::client {

enum class Scheme { Tcp };  // mvw://

struct Url {
    Scheme scheme = Scheme::Tcp;
    protocol::HostPort address;
    std::string model;  // %XX decoded; with or without ".mvw"
};

/// InvalidArgument with a sentence where the text is not such a URL; Unsupported for a scheme that this build cannot
/// do.
Result<Url> parse_url(std::string_view text);

}  // namespace mvw::client
