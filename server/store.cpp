#include "server/store.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <list>
#include <mutex>
#include <utility>

namespace mvw::server {
namespace {

constexpr std::string_view kEnding = ".mvw";
constexpr int kMaxDepth = 16;  // of folders below the served one

class FileModel final : public ModelSource {
 public:
    FileModel(Descriptor file, const FileStamp& stamp, Toc toc, Bytes header)
        : ModelSource(std::move(toc), std::move(header), stamp.bytes), file_(std::move(file)), stamp_(stamp) {}

    Result<void> read(std::uint64_t offset, std::span<std::byte> out) const override {
        return read_all(file_.get(), offset, out);
    }
    int descriptor() const override { return file_.get(); }
    bool intact() const override {
        const Result<FileStamp> now = stamp_of(file_.get());
        return now.ok() && *now == stamp_;
    }

 private:
    Descriptor file_;
    FileStamp stamp_;
};

// The header, read in growing steps because its length is known only once it parses.
Result<Bytes> read_header_bytes(int fd, std::uint64_t file_bytes, FileHeader& header, const Limits& limits) {
    for (std::uint64_t size = 4096;; size *= 4) {
        Bytes bytes(std::min(size, file_bytes));
        if (Result<void> r = read_all(fd, 0, bytes); !r) return r.error();
        Result<FileHeader> parsed = read_header(bytes, limits);
        if (parsed) {
            header = std::move(parsed).value();
            bytes.resize(header.header_bytes);
            return bytes;
        }
        if (parsed.error().code != Errc::NeedMoreData) return parsed.error();
        if (bytes.size() == file_bytes || size > 4ull * limits.max_metadata_bytes)
            return Error{Errc::Malformed, bytes.size(), "the header does not end"};
    }
}

Result<ModelPtr> load(Descriptor file, const FileStamp& stamp, const Limits& limits) {
    FileHeader header;
    Result<Bytes> header_bytes = read_header_bytes(file.get(), stamp.bytes, header, limits);
    if (!header_bytes) return header_bytes.error();
    if (header.index_offset > stamp.bytes || header.index_bytes > stamp.bytes - header.index_offset)
        return Error{Errc::Malformed, 0, "the index is beyond the end of the file"};
    Bytes index(header.index_bytes);
    if (Result<void> r = read_all(file.get(), header.index_offset, index); !r) return r.error();
    Result<Toc> toc = read_toc(header, index, stamp.bytes, limits);
    if (!toc) return toc.error();
    return ModelPtr(std::make_shared<const FileModel>(std::move(file), stamp, std::move(toc).value(),
                                                      std::move(header_bytes).value()));
}

void list_below(Descriptor folder, const std::string& prefix, int depth, std::vector<StoreEntry>& out) {
    DIR* dir = ::fdopendir(::dup(folder.get()));
    if (dir == nullptr) return;
    while (const dirent* entry = ::readdir(dir)) {
        const std::string name = entry->d_name;
        struct stat s {};
        if (name[0] == '.' || ::fstatat(folder.get(), name.c_str(), &s, AT_SYMLINK_NOFOLLOW) != 0) continue;
        if (S_ISREG(s.st_mode) && name.size() > kEnding.size() && name.ends_with(kEnding))
            out.push_back({prefix + name.substr(0, name.size() - kEnding.size()), stamp_of(s)});
        else if (S_ISDIR(s.st_mode) && depth < kMaxDepth)
            if (Descriptor below = open_folder_at(folder.get(), name); below.ok())
                list_below(std::move(below), prefix + name + "/", depth + 1, out);
    }
    ::closedir(dir);
}

class FolderStore final : public Store {
 public:
    FolderStore(Descriptor folder, std::size_t max_open, const Limits& limits)
        : folder_(std::move(folder)), max_open_(max_open), limits_(limits) {}
    Result<ModelPtr> open(std::string_view name) override;
    [[nodiscard]] std::vector<StoreEntry> list() const override;

 private:
    struct Ready {
        std::string name;
        FileStamp stamp;
        ModelPtr model;
    };
    ModelPtr ready(std::string_view name, const FileStamp& stamp);

    const Descriptor folder_;
    const std::size_t max_open_;
    const Limits limits_;
    std::mutex mutex_;
    std::list<Ready> ready_;  // most recently used first
};

// Under the lock: the model kept under that name, in that state; null where there is none.
ModelPtr FolderStore::ready(std::string_view name, const FileStamp& stamp) {
    const auto known =
        std::find_if(ready_.begin(), ready_.end(), [&](const Ready& r) { return r.name == name && r.stamp == stamp; });
    if (known == ready_.end()) return nullptr;
    ready_.splice(ready_.begin(), ready_, known);
    return ready_.front().model;
}

Result<ModelPtr> FolderStore::open(std::string_view name) {
    if (name.ends_with(kEnding)) name.remove_suffix(kEnding.size());
    if (!is_plain_name(name)) return Error{Errc::Io, 0, "no such model"};
    // What is ready needs no opening while its name still leads to the same file, by whatever way.
    struct stat s {};
    if (::fstatat(folder_.get(), (std::string(name) + std::string(kEnding)).c_str(), &s, AT_SYMLINK_NOFOLLOW) == 0) {
        const std::lock_guard lock(mutex_);
        if (const ModelPtr model = ready(name, stamp_of(s))) return model;
    }
    Descriptor file = open_below(folder_.get(), std::string(name) + std::string(kEnding));
    if (!file.ok()) return Error{Errc::Io, 0, "no such model"};
    const Result<FileStamp> stamp = stamp_of(file.get());
    if (!stamp) return Error{Errc::Io, 0, "no such model"};

    const std::lock_guard lock(mutex_);
    if (const ModelPtr model = ready(name, *stamp)) return model;
    ready_.remove_if([&](const Ready& r) { return r.name == name; });
    Result<ModelPtr> model = load(std::move(file), *stamp, limits_);
    if (!model) {
        // An unsound file is there, but not to be had: what is wrong with it is for the log, by the caller.
        const Errc code = model.error().code == Errc::Io ? Errc::Malformed : model.error().code;
        return Error{code, model.error().offset, "the model's file is not sound: " + model.error().message};
    }
    ready_.push_front({std::string(name), *stamp, *model});
    if (ready_.size() > max_open_) ready_.pop_back();
    return ready_.front().model;
}

std::vector<StoreEntry> FolderStore::list() const {
    std::vector<StoreEntry> entries;
    if (Descriptor top = open_folder_at(folder_.get(), "."); top.ok()) list_below(std::move(top), "", 0, entries);
    std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
    return entries;
}

}  // namespace

Result<std::unique_ptr<Store>> Store::open_folder(const std::string& folder, std::size_t max_open,
                                                  const Limits& limits) {
    Descriptor opened = mvw::server::open_folder(folder);
    if (!opened.ok()) return io_error(folder);
    return std::unique_ptr<Store>(std::make_unique<FolderStore>(std::move(opened), max_open, limits));
}

}  // namespace mvw::server
