// What a server bears: idle connections, throughput beside another server's, time to the first chunk in a crowd, and a
// soak of clients that behave badly.
#pragma once
#include <functional>
#include <string>

#include "codec/result.h"
#include "tools/bench/table.h"

namespace mvw::bench {

struct LoadOptions {
    std::string folder;                     // of .mvw files
    std::size_t idle = 10'000;              // connections of the native protocol that say HELLO and nothing more
    std::size_t clients = 64;               // of HTTP at once, each asking for file after file
    std::size_t streams = 2000;             // of the native protocol at once
    double seconds = 3;                     // of each throughput run
    std::size_t rounds = 7;                 // throughput runs of each server
    std::string nginx = "/usr/sbin/nginx";  // not measured where it is not there
};

/// Rows of measure, value, unit, aim: memory for idle connections; HTTP throughput of mvw serve and of nginx with the
/// same files, medians of runs in turn; what the client that got least got; median and p99 of the time from connecting
/// to the first chunk, all streams at once.
Result<Table> run_load(const LoadOptions& options);

struct SoakOptions {
    std::string folder;
    double seconds = 1800;
    std::function<void(const std::string& line)> say;
};

/// Clients that read all, vanish in mid-stream, send noise, or hold a connection half open, against one mvw serve:
/// rows of seconds, memory and descriptors of the server, once a twentieth of the time. Io where it ends, or where its
/// memory or descriptors at the end are more than a tenth (and 4 MB, 8 descriptors) above those after a tenth of the
/// time.
Result<Table> run_soak(const SoakOptions& options);

}  // namespace mvw::bench
