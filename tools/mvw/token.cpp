// mvw token: an access token for a server that has the same key.
#include <fmt/core.h>

#include <charconv>
#include <chrono>
#include <memory>
#include <optional>

#include "server/token.h"
#include "tools/mvw/commands.h"

namespace mvw::cli {
namespace {

struct TokenArguments {
    std::string key_file, models = "*", expires = "24h";
};

// "30m", "24h", "7d" from now, or seconds since 1970.
std::optional<std::int64_t> expiry(const std::string& text, std::int64_t now) {
    std::int64_t n = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
    if (error != std::errc{} || n <= 0) return std::nullopt;
    const std::string unit(end, text.data() + text.size());
    if (unit.empty()) return n;
    const std::int64_t seconds = unit == "s" ? 1 : unit == "m" ? 60 : unit == "h" ? 3600 : unit == "d" ? 86400 : 0;
    if (seconds == 0 || n > (std::int64_t{1} << 40) / seconds) return std::nullopt;
    return now + n * seconds;
}

void token(const TokenArguments& arguments) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const std::optional<std::int64_t> expires =
        expiry(arguments.expires, std::chrono::duration_cast<std::chrono::seconds>(now).count());
    if (!expires) throw Fatal{kUsage, "--expires " + arguments.expires + ": neither like 30m, 24h or 7d nor a time"};
    const Result<server::TokenKeys> keys = server::TokenKeys::read(arguments.key_file);
    if (!keys) throw Fatal{kFailure, keys.error().message};
    const Result<std::string> made = server::make_token(keys->keys().front(), arguments.models, *expires);
    if (!made) throw Fatal{kFailure, made.error().message};
    fmt::print("{}\n", *made);
}

}  // namespace

void add_token(CLI::App& app) {
    auto arguments = std::make_shared<TokenArguments>();
    CLI::App* command = app.add_subcommand("token", "Prints an access token for mvw serve --tokens");
    command->footer(
        "Example: head -c 32 /dev/urandom | base64 >keys && mvw token --key keys --models 'scans/*' --expires 7d");
    command->add_option("--key", arguments->key_file, "The server's file of keys; the first one signs")->required();
    command->add_option("--models", arguments->models, "Names of models that it opens; * stands for any characters")
        ->capture_default_str();
    command
        ->add_option("--expires", arguments->expires,
                     "How long it is good for (30m, 24h, 7d), or until when in seconds since 1970")
        ->capture_default_str();
    command->callback([arguments] { token(*arguments); });
}

}  // namespace mvw::cli
