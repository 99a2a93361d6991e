// Access tokens: who holds one may open the models that its pattern names, until it expires. Signed with HMAC-SHA256
// (RFC 2104), so a server needs the key and keeps no list. PROTOCOL.md 9 is normative.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "codec/result.h"

namespace mvw::server {

/// "v1.EXPIRES.PATTERN.SIGNATURE": seconds since 1970, base64url of the pattern, base64url of the HMAC of all before.
///
/// key      at least 16 bytes; InvalidArgument for less
/// pattern  of model names: '*' stands for any run of characters, '/' included
/// expires  seconds since 1970
Result<std::string> make_token(std::string_view key, std::string_view pattern, std::int64_t expires);

/// The keys that tokens may be signed with; two of them let one be retired while tokens of both are about.
class TokenKeys {
 public:
    /// A line a key, at least 16 bytes, '#' begins a comment. Io where the file cannot be read, InvalidArgument where
    /// it has a shorter key or none.
    static Result<TokenKeys> read(const std::string& path);
    explicit TokenKeys(std::vector<std::string> keys) : keys_(std::move(keys)) {}

    /// Success where the token is signed with one of the keys, has not expired at `now` (seconds since 1970) and its
    /// pattern matches `model` (a ".mvw" at its end aside). Signatures are compared in constant time. Else
    /// InvalidArgument with a sentence that gives nothing away.
    [[nodiscard]] Result<void> check(std::string_view token, std::string_view model, std::int64_t now) const;
    [[nodiscard]] const std::vector<std::string>& keys() const { return keys_; }

 private:
    std::vector<std::string> keys_;
};

/// True where `pattern` with its '*' covers all of `text`. O(pattern * text).
bool matches(std::string_view pattern, std::string_view text);

}  // namespace mvw::server
