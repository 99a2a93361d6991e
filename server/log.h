// Where a server's log lines go. Libraries do not print: the program decides.
#pragma once
#include <functional>
#include <string>

namespace mvw::server {

enum class LogLevel { Debug, Info, Warning };

/// Takes one line of key=value pairs ("event=closed peer=127.0.0.1:4242 chunks=17"). Called from several threads.
using Log = std::function<void(LogLevel level, const std::string& line)>;

/// A value for such a line: in quotes, with quotes, backslashes and control characters escaped, where it needs them
/// (names and reasons may come from a peer).
std::string log_value(const std::string& text);

}  // namespace mvw::server
