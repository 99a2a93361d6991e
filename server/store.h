// Read-only catalogue of the .mvw files below one folder. Nothing above the folder can be reached and no symbolic link
// below it is followed. Headers and indices are in memory; payloads are read from open descriptors, never mapped (a
// mapped file that shrinks kills the process).
#pragma once
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "codec/limits.h"
#include "server/files.h"

namespace mvw::server {

/// A file that could be served.
struct StoreEntry {
    std::string name;  // path below the folder, without ".mvw"
    FileStamp stamp;
};

/// The folder's models. Safe to use from several threads.
class Store {
 public:
    /// Io where `folder` cannot be opened. `max_open` models are kept ready besides those in use.
    static Result<std::unique_ptr<Store>> open_folder(const std::string& folder, std::size_t max_open,
                                                      const Limits& limits = {});
    Store(const Store&) = delete;
    Store& operator=(const Store&) = delete;

    /// The model of that name as it is on disk now: a file added, replaced or removed since the last call is noticed
    /// here. Io: no such model, or the name is not a plain path. Malformed and the like: the file is not a sound .mvw.
    Result<ModelPtr> open(std::string_view name);

    /// All .mvw files below the folder, by name, as they are now. Reads the folders alone.
    [[nodiscard]] std::vector<StoreEntry> list() const;

 private:
    struct Ready {
        std::string name;
        FileStamp stamp;
        ModelPtr model;
    };
    Store(Descriptor folder, std::size_t max_open, const Limits& limits)
        : folder_(std::move(folder)), max_open_(max_open), limits_(limits) {}

    const Descriptor folder_;
    const std::size_t max_open_;
    const Limits limits_;
    std::mutex mutex_;
    std::list<Ready> ready_;  // most recently used first
};

}  // namespace mvw::server
