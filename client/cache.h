// Chunks kept on disk between runs, by content id: what is there is never asked for again. Bounded; the models used
// longest ago go first.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "client/session.h"

namespace mvw::client {

/// One model's place in a cache folder. Several programs may share a folder: a record is one append, and a damaged or
/// cut one is left out when it is read. Not thread-safe.
class ChunkCache {
 public:
    struct Options {
        std::string folder;                    // made where it is not there
        std::uint64_t max_bytes = 1ull << 30;  // of all files in it
    };

    /// `url` names what was fetched: the model that it last led to is what load() gives.
    ChunkCache(Options options, std::string url);
    ~ChunkCache();
    ChunkCache(const ChunkCache&) = delete;
    ChunkCache& operator=(const ChunkCache&) = delete;

    /// What is known of the URL's model; nothing where nothing sound is.
    std::optional<Stored> load(const Limits& limits);
    /// The model that the URL leads to, as opened: chunks that follow are its own.
    void begin(const Opened& opened, const std::string& etag);
    /// Keeps a chunk. Failures (a full disk) are passed over: the cache only ever saves time.
    void put(const Received& chunk);

 private:
    [[nodiscard]] std::string path(const std::string& name) const;
    [[nodiscard]] std::string alias() const;  // name of the file that says what the URL leads to
    void make_room(const std::string& keep) const;
    void close();

    const Options options_;
    const std::string url_;
    int file_ = -1;
    std::uint64_t file_bytes_ = 0;
    protocol::ChunkSet kept_;
    std::string kept_name_;  // of the file that kept_ is about
};

}  // namespace mvw::client
