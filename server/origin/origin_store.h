// Models of an HTTP store (any server with Range; S3-compatible ones by public or pre-signed URLs), kept in part on
// this machine's disk: what peers ask for is fetched once, in pieces, and sent from the disk from then on.
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "server/metrics.h"
#include "server/store.h"

namespace mvw::server {

struct OriginOptions {
    std::string url{};      // models are below it: URL/NAME.mvw, with the query of URL behind
    std::string list{};     // instead of `url`: a file of lines "NAME URL", read again when it changes
    std::string ca_file{};  // PEM file of who signs the store's certificates; empty: the system's
    std::string folder{};   // of the cache, which is one server's own
    std::uint64_t cache_bytes = 10ull << 30;      // of all files in it, each counted whole
    std::chrono::milliseconds fresh_time{5'000};  // after which an opened model is looked up again
    std::size_t max_open = 256;                   // models kept ready besides those in use
    Limits limits{};
};

/// A Store whose open() says NeedMoreData while it asks the other one. A model that the other store has replaced is
/// noticed when it is opened again or its next piece comes; where that store cannot be reached, models that were opened
/// before stay what they were. list() names what the list file names, or what has been opened.
/// `metrics` outlives the store. It has one thread of its own, which ends with it.
Result<std::unique_ptr<Store>> open_origin(OriginOptions options, Metrics& metrics);

}  // namespace mvw::server
