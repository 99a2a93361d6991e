// What strangers may write into a request's range or coding, a token or a URL: any text is answered or refused, and a
// range never leaves its file.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "client/url.h"
#include "server/site.h"
#include "server/token.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 1) return 0;
    const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
    const std::uint64_t bytes = data[0] * std::uint64_t{0x01010101};
    mvw::server::ByteRange range;
    if (mvw::server::parse_range(text, bytes, range) == mvw::server::RangeKind::Part)
        if (range.first > range.last || range.last >= bytes) std::abort();
    if (mvw::server::accepts(text, "br") && text.find("br") == std::string::npos) std::abort();
    static const mvw::server::TokenKeys keys({"a key of at least 16 bytes"});
    if (keys.check(text, "model", 0).ok()) std::abort();  // nobody guesses a signature
    if (const auto url = mvw::client::parse_url(text);
        url.ok() && url->target.find_first_of("\r\n ") != std::string::npos)
        std::abort();
    return 0;
}
