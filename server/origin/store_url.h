// Where an HTTP store keeps something: http[s]://HOST[:PORT]/PATH[?QUERY].
#pragma once
#include <string>
#include <string_view>

#include "server/protocol/address.h"

namespace mvw::server {

struct StoreUrl {
    protocol::HostPort address;
    bool tls = false;
    std::string target;  // path and query, as written: signatures are over these very characters
};

/// InvalidArgument with a sentence where the text is not such a URL.
Result<StoreUrl> parse_store_url(std::string_view text);

/// The URL of model `name` below `base`: PATH/NAME.mvw, with the base's query behind it.
StoreUrl url_below(const StoreUrl& base, std::string_view name);

}  // namespace mvw::server
