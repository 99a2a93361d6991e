#include "server/catalogue.h"

#include <fmt/format.h>

#include <algorithm>

namespace mvw::server {
namespace {

ModelSummary summarise(const std::string& name, const ModelSource& model) {
    const FileHeader& header = model.toc().header;
    ModelSummary s{.name = name, .version = to_hex(header.content_id), .bytes = model.file_bytes()};
    s.levels = finest_level(header);
    for (std::size_t p = 0; p < header.main_parts(); ++p) {
        const PartInfo& part = header.parts[p];
        ++s.parts;
        s.base_faces += part.base_faces;
        s.faces += std::uint64_t{part.base_faces} << 2 * part.levels;  // levels <= 15: no overflow
    }
    return s;
}

}  // namespace

std::string to_hex(const std::array<std::uint8_t, 16>& content_id) {
    std::string out;
    for (const std::uint8_t byte : content_id) out += fmt::format("{:02x}", byte);
    return out;
}

std::vector<ModelSummary> Catalogue::list() {
    const std::vector<StoreEntry> entries = store_.list();
    const std::lock_guard lock(mutex_);
    std::map<std::string, Known> now;
    std::vector<ModelSummary> summaries;
    for (const StoreEntry& entry : entries) {
        auto known = known_.extract(entry.name);
        if (known.empty() || known.mapped().stamp != entry.stamp) {
            const Result<ModelPtr> model = store_.open_as_known(entry.name);
            if (!model && model.error().code == Errc::NeedMoreData) continue;  // next time
            Known fresh{entry.stamp, std::nullopt};
            if (model) fresh.summary = summarise(entry.name, **model);
            now.emplace(entry.name, std::move(fresh));
        } else {
            now.insert(std::move(known));
        }
        if (const Known& k = now.at(entry.name); k.summary) summaries.push_back(*k.summary);
    }
    known_ = std::move(now);
    return summaries;
}

}  // namespace mvw::server
