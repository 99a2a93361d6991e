// Percent-encoded text in URLs (RFC 3986, 2.1).
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace mvw::protocol {

/// The text with each %XX as its byte; none where two hexadecimal digits do not follow a percent sign.
std::optional<std::string> percent_decode(std::string_view text);

/// A path with every byte but letters, digits and "/-._~" as %XX.
std::string percent_encode(std::string_view path);

}  // namespace mvw::protocol
