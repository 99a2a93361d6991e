#include "client/url.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "server/protocol/percent.h"

namespace mvw::client {
namespace {

struct SchemeName {
    std::string_view name;
    Scheme scheme;
    bool tls;
    std::uint16_t port;
};

const SchemeName* find_scheme(std::string_view name) {
    static constexpr SchemeName kSchemes[] = {{"mvw", Scheme::Tcp, false, protocol::kDefaultPort},
                                              {"mvws", Scheme::Tcp, true, protocol::kDefaultPort},
                                              {"ws", Scheme::WebSocket, false, 80},
                                              {"wss", Scheme::WebSocket, true, 443},
                                              {"http", Scheme::Http, false, 80},
                                              {"https", Scheme::Http, true, 443}};
    const auto* found =
        std::find_if(std::begin(kSchemes), std::end(kSchemes), [&](const auto& s) { return s.name == name; });
    return found == std::end(kSchemes) ? nullptr : found;
}

}  // namespace

Result<Url> parse_url(std::string_view text) {
    constexpr std::size_t kMaxModelBytes = 1024;  // MessageLimits::max_name_bytes
    const auto bad = [&](Errc code, const std::string& why) {
        return Error{code, 0, "\"" + std::string(text) + "\": " + why};
    };
    const std::size_t colon = text.find("://");
    if (colon == std::string_view::npos) return bad(Errc::InvalidArgument, "not a URL like mvw://host:port/model");
    const SchemeName* scheme = find_scheme(text.substr(0, colon));
    if (scheme == nullptr) return bad(Errc::Unsupported, "only mvw, mvws, ws, wss, http and https URLs can be fetched");
    const std::string_view rest = text.substr(colon + 3);
    const std::size_t slash = rest.find('/');
    if (slash == std::string_view::npos || slash + 1 == rest.size())
        return bad(Errc::InvalidArgument, "no model is named after the host");
    if (rest.find_first_of(" \t\r\n#") != std::string_view::npos)
        return bad(Errc::InvalidArgument, "blanks, line ends and '#' have no place in it");
    Result<protocol::HostPort> address = protocol::parse_host_port(rest.substr(0, slash), scheme->port);
    if (!address) return address.error();
    if (address->port == 0) return bad(Errc::InvalidArgument, "port 0 cannot be connected to");
    Url url{scheme->scheme, std::move(address).value(), "", scheme->tls, std::string(rest.substr(slash))};
    std::string_view path = rest.substr(slash + 1);
    if (url.scheme == Scheme::Http) path = path.substr(0, path.find('?'));
    std::optional<std::string> model = protocol::percent_decode(path);
    if (!model) return bad(Errc::InvalidArgument, "a % is not followed by two hexadecimal digits");
    if (model->size() > kMaxModelBytes) return bad(Errc::InvalidArgument, "the model's name is too long");
    url.model = std::move(*model);
    return url;
}

}  // namespace mvw::client
