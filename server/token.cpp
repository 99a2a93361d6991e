#include "server/token.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <array>
#include <charconv>
#include <fstream>
#include <optional>

namespace mvw::server {
namespace {

constexpr std::size_t kMinKeyBytes = 16;
constexpr std::string_view kVersion = "v1";
constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

// RFC 4648 5, without padding.
std::string base64url(std::string_view bytes) {
    std::string out;
    unsigned held = 0, bits = 0;
    for (const char c : bytes) {
        held = held << 8 | static_cast<unsigned char>(c);
        for (bits += 8; bits >= 6; bits -= 6) out += kAlphabet[held >> (bits - 6) & 63];
    }
    if (bits > 0) out += kAlphabet[held << (6 - bits) & 63];
    return out;
}

std::optional<std::string> from_base64url(std::string_view text) {
    std::string out;
    unsigned held = 0, bits = 0;
    for (const char c : text) {
        const std::size_t value = kAlphabet.find(c);
        if (value == std::string_view::npos) return std::nullopt;
        held = held << 6 | static_cast<unsigned>(value);
        if ((bits += 6) >= 8) out += static_cast<char>(held >> (bits -= 8) & 0xFF);
    }
    return out;
}

std::string signature(std::string_view key, std::string_view text) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
    unsigned size = 0;
    HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), reinterpret_cast<const unsigned char*>(text.data()),
         text.size(), digest.data(), &size);
    return base64url({reinterpret_cast<const char*>(digest.data()), size});
}

bool same(std::string_view a, std::string_view b) {
    return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

struct Fields {
    std::string_view signed_text, signature;
    std::int64_t expires = 0;
    std::string pattern;
};

std::optional<Fields> split(std::string_view token) {
    Fields f;
    const std::size_t last = token.rfind('.'), first = token.find('.');
    const std::size_t second = first == std::string_view::npos ? first : token.find('.', first + 1);
    if (second == std::string_view::npos || last <= second || token.substr(0, first) != kVersion) return std::nullopt;
    f.signed_text = token.substr(0, last);
    f.signature = token.substr(last + 1);
    const std::string_view expires = token.substr(first + 1, second - first - 1);
    const auto [end, error] = std::from_chars(expires.data(), expires.data() + expires.size(), f.expires);
    if (error != std::errc{} || end != expires.data() + expires.size()) return std::nullopt;
    std::optional<std::string> pattern = from_base64url(token.substr(second + 1, last - second - 1));
    if (!pattern) return std::nullopt;
    f.pattern = std::move(*pattern);
    return f;
}

}  // namespace

bool matches(std::string_view pattern, std::string_view text) {
    std::size_t p = 0, t = 0, star = std::string_view::npos, resume = 0;
    while (t < text.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            resume = t;
        } else if (p < pattern.size() && pattern[p] == text[t]) {
            ++p, ++t;
        } else if (star != std::string_view::npos) {
            p = star + 1;
            t = ++resume;
        } else {
            return false;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

Result<std::string> make_token(std::string_view key, std::string_view pattern, std::int64_t expires) {
    if (key.size() < kMinKeyBytes) return Error{Errc::InvalidArgument, 0, "a key has at least 16 bytes"};
    const std::string text = std::string(kVersion) + "." + std::to_string(expires) + "." + base64url(pattern);
    return text + "." + signature(key, text);
}

Result<TokenKeys> TokenKeys::read(const std::string& path) {
    std::ifstream in(path);
    if (!in) return Error{Errc::Io, 0, path + ": cannot be read"};
    std::vector<std::string> keys;
    for (std::string line; std::getline(in, line);) {
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        if (line.empty() || line[0] == '#') continue;
        if (line.size() < kMinKeyBytes) return Error{Errc::InvalidArgument, 0, path + ": a key has at least 16 bytes"};
        keys.push_back(std::move(line));
    }
    if (keys.empty()) return Error{Errc::InvalidArgument, 0, path + ": no key in it"};
    return TokenKeys(std::move(keys));
}

Result<void> TokenKeys::check(std::string_view token, std::string_view model, std::int64_t now) const {
    const Error refused{Errc::InvalidArgument, 0, "the token does not allow this model"};
    if (token.empty()) return Error{Errc::InvalidArgument, 0, "a token is needed"};
    const std::optional<Fields> fields = split(token);
    if (!fields) return refused;
    bool is_signed = false;
    for (const std::string& key : keys_) is_signed |= same(signature(key, fields->signed_text), fields->signature);
    if (!is_signed) return refused;
    if (fields->expires <= now) return Error{Errc::InvalidArgument, 0, "the token has expired"};
    if (model.ends_with(".mvw")) model.remove_suffix(4);
    if (!matches(fields->pattern, model)) return refused;
    return {};
}

}  // namespace mvw::server
