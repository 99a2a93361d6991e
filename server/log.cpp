#include "server/log.h"

#include <fmt/format.h>

namespace mvw::server {

std::string log_value(const std::string& text) {
    std::string out = "\"";
    bool plain = !text.empty();
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (code <= ' ' || code == '=' || code == '"' || code == '\\' || code == 0x7F) plain = false;
        if (code < ' ' || code == 0x7F)
            out += fmt::format("\\x{:02x}", code);
        else if (c == '"' || c == '\\')
            (out += '\\') += c;
        else
            out += c;
    }
    return plain ? text : out + '"';
}

}  // namespace mvw::server
