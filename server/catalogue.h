// The list of models as HTTP tells it.
#pragma once
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/store.h"

namespace mvw::server {

/// What a page needs to know of a model before it opens it.
struct ModelSummary {
    std::string name;
    std::string version;  // the content id, 32 hexadecimal digits
    std::uint64_t bytes = 0;
    std::uint32_t parts = 0, base_faces = 0;
    std::uint64_t faces = 0;  // of the finest level
    unsigned levels = 0;
};

/// Summaries of a store's models. Each file is looked into once for each state of it. Safe to use from several threads.
class Catalogue {
 public:
    explicit Catalogue(Store& store) : store_(store) {}
    /// All sound models as they are now, by name. O(files), and a read of each that is new.
    std::vector<ModelSummary> list();

 private:
    struct Known {
        FileStamp stamp;
        std::optional<ModelSummary> summary;  // none: the file is not sound
    };
    Store& store_;
    std::mutex mutex_;
    std::map<std::string, Known> known_;
};

/// 32 hexadecimal digits.
std::string to_hex(const std::array<std::uint8_t, 16>& content_id);

}  // namespace mvw::server
