// Read-only catalogue of .mvw files. Nothing above its folder can be reached and no symbolic link below it is followed.
// Headers and indices are in memory; payloads are read from open descriptors, never mapped (a mapped file that shrinks
// kills the process).
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
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

/// Models by name, from wherever they are (a folder here, an HTTP store in origin/). Safe to use from several threads.
class Store {
 public:
    /// A folder's models. Io where `folder` cannot be opened. `max_open` models are kept ready besides those in use.
    static Result<std::unique_ptr<Store>> open_folder(const std::string& folder, std::size_t max_open,
                                                      const Limits& limits = {});
    virtual ~Store() = default;
    Store(const Store&) = delete;
    Store& operator=(const Store&) = delete;

    /// The model of that name as it is now: a file added, replaced or removed since the last call is noticed here.
    /// Io: no such model, or the name is not a plain path. NeedMoreData: it is being looked up, see when_known().
    /// Malformed and the like: there is one, and it is not a sound .mvw or cannot be had at the moment.
    virtual Result<ModelPtr> open(std::string_view name) = 0;

    /// The same where what was found last will do as well: for lists.
    virtual Result<ModelPtr> open_as_known(std::string_view name) { return open(name); }

    /// Calls `then` once, from any thread or at once, when open() has another answer than NeedMoreData.
    virtual void when_known(std::string_view, const std::function<void()>& then) { then(); }

    /// All .mvw files below the folder, by name, as they are now. Reads the folders alone.
    [[nodiscard]] virtual std::vector<StoreEntry> list() const = 0;

 protected:
    Store() = default;
};

}  // namespace mvw::server
