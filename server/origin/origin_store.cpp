#include "server/origin/origin_store.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>
#include <vector>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/executor_work_guard.hpp>

#include "server/catalogue.h"
#include "server/origin/origin_model.h"

namespace mvw::server {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;
using OriginModelPtr = std::shared_ptr<const OriginModel>;

constexpr std::string_view kEnding = ".mvw";
constexpr std::size_t kConnections = 16;          // to the store
constexpr std::size_t kMaxLooking = 64;           // look-ups under way: names are the peers' choice
constexpr std::uint64_t kHeadBytes = 128u << 10;  // of a look-up's first request; whole blocks

Error no_such_model() {
    return {Errc::Io, 0, "no such model"};
}
// As for a file that is not sound: there, perhaps, and not to be had.
Error not_to_be_had(const std::string& why) {
    return {Errc::Malformed, 0, why};
}

/// The cache's folder: names of files there, oldest use first.
struct CacheEntry {
    std::string name;
    std::uint64_t bytes = 0;
    std::int64_t used_ns = 0;
};

std::vector<CacheEntry> list_cache(const std::string& folder) {
    std::vector<CacheEntry> entries;
    DIR* dir = ::opendir(folder.c_str());
    if (dir == nullptr) return entries;
    while (const dirent* found = ::readdir(dir)) {
        std::string name = found->d_name;
        struct stat s {};
        if (!name.ends_with(CachedFile::kBytesEnding) || ::fstatat(::dirfd(dir), name.c_str(), &s, 0) != 0) continue;
        const FileStamp stamp = stamp_of(s);
        name.resize(name.size() - CachedFile::kBytesEnding.size());
        entries.push_back({std::move(name), stamp.bytes, stamp.modified_ns});
    }
    ::closedir(dir);
    std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.used_ns < b.used_ns; });
    return entries;
}

// Lines of "NAME URL"; blank ones and those that begin with '#' are passed over.
Result<std::map<std::string, StoreUrl>> read_list(const std::string& path) {
    std::ifstream in(path);
    if (!in) return Error{Errc::Io, 0, path + ": cannot be read"};
    std::map<std::string, StoreUrl> urls;
    std::size_t number = 0;
    for (std::string line; std::getline(in, line);) {
        ++number;
        std::istringstream words(line);
        std::string name, text, more;
        if (!(words >> name) || name[0] == '#') continue;
        words >> text >> more;
        Result<StoreUrl> url = parse_store_url(text);
        if (name.ends_with(kEnding)) name.resize(name.size() - kEnding.size());
        if (!url || !more.empty() || !is_plain_name(name))
            return Error{Errc::InvalidArgument, 0, path + ": line " + std::to_string(number) + " is not \"NAME URL\""};
        urls.insert_or_assign(name, std::move(url).value());
    }
    return urls;
}

class OriginStore final : public Store {
 public:
    OriginStore(OriginOptions options, Metrics& metrics, Descriptor folder)
        : options_(std::move(options)),
          folder_(std::move(folder)),
          work_(asio::make_work_guard(io_)),
          metrics_(metrics) {}
    ~OriginStore() override {
        io_.stop();
        if (thread_.joinable()) thread_.join();
        client_.reset();  // its sockets belong to io_
    }

    Result<void> start() {
        if (::flock(folder_.get(), LOCK_EX | LOCK_NB) != 0)
            return Error{Errc::Io, 0, options_.folder + ": another server has its cache there"};
        if (options_.list.empty()) {
            Result<StoreUrl> base = parse_store_url(options_.url);
            if (!base) return base.error();
            base_ = std::move(base).value();
        } else if (Result<void> r = renew_list(); !r) {
            return r;
        }
        Result<std::unique_ptr<HttpClient>> client = HttpClient::make(io_, options_.ca_file, kConnections);
        if (!client) return client.error();
        client_ = std::move(client).value();
        link_ = std::make_unique<const OriginLink>(OriginLink{io_, *client_, metrics_});
        thread_ = std::thread([this] { io_.run(); });
        return {};
    }

    Result<ModelPtr> open(std::string_view name) override {
        if (name.ends_with(kEnding)) name.remove_suffix(kEnding.size());
        if (!is_plain_name(name)) return no_such_model();
        const std::lock_guard lock(mutex_);
        const std::optional<StoreUrl> url = url_of(std::string(name));
        if (!url) return no_such_model();
        if (const auto known = entries_.find(name); known != entries_.end() && is_fresh(known->second)) {
            known->second.used = ++uses_;
            if (known->second.model) return ModelPtr(known->second.model);
            return known->second.failure;
        }
        if (looking_ >= kMaxLooking) return not_to_be_had("too many models are being looked up");
        forget_old_entries();
        begin_look_up(std::string(name), *url);
        return Error{Errc::NeedMoreData, 0, "the model is being looked up"};
    }

    Result<ModelPtr> open_as_known(std::string_view name) override {
        {
            const std::lock_guard lock(mutex_);
            const auto known = entries_.find(name);
            if (known != entries_.end() && known->second.model) return ModelPtr(known->second.model);
        }
        return open(name);
    }

    void when_known(std::string_view name, const std::function<void()>& then) override {
        if (name.ends_with(kEnding)) name.remove_suffix(kEnding.size());
        {
            const std::lock_guard lock(mutex_);
            const auto found = entries_.find(name);
            if (found != entries_.end() && found->second.looking) {
                found->second.waiting.push_back(then);
                return;
            }
        }
        then();
    }

    [[nodiscard]] std::vector<StoreEntry> list() const override {
        const std::lock_guard lock(mutex_);
        std::map<std::string, FileStamp> stamps;
        for (const auto& [name, url] : urls_) stamps[name];
        for (const auto& [name, entry] : entries_)
            if (entry.model) stamps[name] = stamp_of(*entry.model);
        std::vector<StoreEntry> entries;
        entries.reserve(stamps.size());
        for (const auto& [name, stamp] : stamps) entries.push_back({name, stamp});
        return entries;
    }

 private:
    struct Entry {
        bool looking = false;
        std::optional<Clock::time_point> checked;
        OriginModelPtr model;
        Error failure;  // where there is no model
        std::vector<std::function<void()>> waiting;
        std::uint64_t used = 0;
    };

    static FileStamp stamp_of(const OriginModel& model) {
        FileStamp stamp;
        stamp.bytes = model.file_bytes();
        for (const std::uint8_t byte : model.toc().header.content_id) stamp.inode = stamp.inode * 257 + byte;
        return stamp;
    }

    [[nodiscard]] bool is_fresh(const Entry& e) const {
        if (e.looking || !e.checked || *e.checked + options_.fresh_time < Clock::now()) return false;
        return !e.model || (e.model->intact() && !e.model->refused());
    }

    std::optional<StoreUrl> url_of(const std::string& name) {
        if (options_.list.empty()) return url_below(base_, name);
        if (!renew_list()) return std::nullopt;
        const auto found = urls_.find(name);
        return found == urls_.end() ? std::nullopt : std::optional(found->second);
    }

    // A list that cannot be read at the moment stays what it was, unless it is the first.
    Result<void> renew_list() {
        struct stat s {};
        if (::stat(options_.list.c_str(), &s) != 0) return urls_.empty() ? io_error(options_.list) : Result<void>();
        if (const FileStamp now = server::stamp_of(s); now != list_stamp_) {
            Result<std::map<std::string, StoreUrl>> urls = read_list(options_.list);
            if (!urls) return urls_.empty() ? urls.error() : Result<void>();
            urls_ = std::move(urls).value();
            list_stamp_ = now;
        }
        return {};
    }

    void forget_old_entries() {
        while (entries_.size() >= options_.max_open) {
            auto oldest = entries_.end();
            for (auto e = entries_.begin(); e != entries_.end(); ++e)
                if (!e->second.looking && (oldest == entries_.end() || e->second.used < oldest->second.used))
                    oldest = e;
            if (oldest == entries_.end()) return;
            entries_.erase(oldest);
        }
    }

    void begin_look_up(std::string name, StoreUrl url) {
        Entry& entry = entries_[name];
        if (std::exchange(entry.looking, true)) return;
        ++looking_;
        asio::co_spawn(
            io_,
            [this, name = std::move(name), url = std::move(url), known = entry.model] {
                return look_up(name, url, known);
            },
            asio::detached);
    }

    asio::awaitable<void> look_up(std::string name, StoreUrl url, OriginModelPtr known) {
        const bool sound = known && known->intact() && !known->refused();
        const std::string unless = sound ? known->validator() : std::string();
        Result<OriginModelPtr> found = co_await find(url, unless);
        // Nothing new, or nobody there to ask: what is known stays.
        if (sound && !found && (found.error().code == Errc::NeedMoreData || found.error().code == Errc::Malformed))
            found = known;
        std::vector<std::function<void()>> waiting;
        {
            const std::lock_guard lock(mutex_);
            Entry& entry = entries_[name];
            entry.looking = false;
            entry.checked = Clock::now();
            entry.used = ++uses_;
            entry.model = found.ok() ? *found : nullptr;
            if (!found) entry.failure = found.error();
            waiting = std::exchange(entry.waiting, {});
            --looking_;
        }
        for (const auto& then : waiting) then();
    }

    // NeedMoreData: it is as `unless` says. Io: there is none. Malformed and the like: it is not to be had.
    asio::awaitable<Result<OriginModelPtr>> find(StoreUrl url, std::string unless) {
        const std::string always;  // named: g++ 12 mixes up temporaries that live across a co_await
        Result<RangeAnswer> head = co_await link_->get(url, 0, kHeadBytes - 1, unless);
        if (!head) co_return not_to_be_had(head.error().message);
        if (head->status == 304) co_return Error{Errc::NeedMoreData, 0, "unchanged"};
        if (head->status == 404 || head->status == 403 || head->status == 410) co_return no_such_model();
        if (head->status != 206) co_return not_to_be_had("the store answers " + std::to_string(head->status));
        const RangeAnswer first = std::move(head).value();
        Bytes bytes = first.body;
        Result<FileHeader> header = read_header(bytes, options_.limits);
        while (!header && header.error().code == Errc::NeedMoreData && bytes.size() < first.file_bytes) {
            if (bytes.size() > 4ull * options_.limits.max_metadata_bytes) break;
            Result<RangeAnswer> more = co_await link_->get(url, bytes.size(), 4 * bytes.size() - 1, always);
            if (!more || more->status != 206 || !same_file(*more, first) || more->body.empty())
                co_return not_to_be_had("the store's answers do not belong together");
            bytes.insert(bytes.end(), more->body.begin(), more->body.end());
            header = read_header(bytes, options_.limits);
        }
        if (!header) co_return not_to_be_had("not a sound .mvw: " + header.error().message);
        if (header->index_offset > first.file_bytes || header->index_bytes > first.file_bytes - header->index_offset)
            co_return not_to_be_had("the index is beyond the end of the file");
        Result<std::shared_ptr<CachedFile>> file = cached_file(*header, first.file_bytes);
        if (!file) co_return not_to_be_had(file.error().message);
        if (Result<void> kept = (*file)->put(0, bytes); !kept) co_return not_to_be_had(kept.error().message);
        Result<Bytes> index = co_await read_index(url, *header, first, *file);
        if (!index) co_return index.error();
        Result<Toc> toc = read_toc(*header, *index, first.file_bytes, options_.limits);
        if (!toc) co_return not_to_be_had("not a sound .mvw: " + toc.error().message);
        bytes.resize(header->header_bytes);
        co_return OriginModelPtr(std::make_shared<const OriginModel>(
            *link_, url, first.validator, std::move(toc).value(), std::move(bytes), first.file_bytes, *file));
    }

    static bool same_file(const RangeAnswer& a, const RangeAnswer& b) {
        return a.file_bytes == b.file_bytes && a.validator == b.validator;
    }

    // From the cache, or from the store in whole blocks, so that it is in the cache then.
    asio::awaitable<Result<Bytes>> read_index(StoreUrl url, FileHeader header, RangeAnswer first,
                                              std::shared_ptr<CachedFile> file) {
        if (!file->has(header.index_offset, header.index_bytes)) {
            const std::uint64_t from = header.index_offset / CachedFile::kBlockBytes * CachedFile::kBlockBytes;
            const std::string always;
            const Result<RangeAnswer> answer = co_await link_->get(url, from, first.file_bytes - 1, always);
            if (!answer || answer->status != 206 || !same_file(*answer, first))
                co_return not_to_be_had("the store's answers do not belong together");
            if (Result<void> kept = file->put(from, answer->body); !kept) co_return not_to_be_had(kept.error().message);
        }
        Bytes index(header.index_bytes);
        if (Result<void> r = file->read(header.index_offset, index); !r) co_return not_to_be_had(r.error().message);
        co_return index;
    }

    // The model's place in the cache, once there is room for all of it.
    Result<std::shared_ptr<CachedFile>> cached_file(const FileHeader& header, std::uint64_t file_bytes) {
        const std::string name = to_hex(header.content_id);
        if (std::shared_ptr<CachedFile> open = open_files_[name].lock()) return open;
        if (!make_room(name, file_bytes)) return Error{Errc::LimitExceeded, 0, "the cache has no room for the model"};
        Result<std::shared_ptr<CachedFile>> file = CachedFile::open(folder_.get(), name, file_bytes);
        if (file.ok()) open_files_[name] = *file;
        return file;
    }

    bool make_room(const std::string& keep, std::uint64_t bytes) {
        std::erase_if(open_files_, [](const auto& f) { return f.second.expired(); });
        for (const bool drop_ready : {false, true}) {
            if (drop_ready) drop_ready_models();
            std::uint64_t total = bytes;
            const std::vector<CacheEntry> files = list_cache(options_.folder);
            for (const CacheEntry& file : files) total += file.name == keep ? 0 : file.bytes;
            for (const CacheEntry& file : files) {
                if (total <= options_.cache_bytes) return true;
                if (file.name == keep || !open_files_[file.name].expired()) continue;
                CachedFile::remove(folder_.get(), file.name);
                total -= file.bytes;
            }
            if (total <= options_.cache_bytes) return true;
        }
        return false;
    }

    // Models that nobody streams at the moment: to be looked up again when somebody does.
    void drop_ready_models() {
        const std::lock_guard lock(mutex_);
        std::erase_if(entries_, [](const auto& e) { return !e.second.looking && e.second.model.use_count() <= 1; });
    }

    const OriginOptions options_;
    const Descriptor folder_;
    asio::io_context io_{1};
    asio::executor_work_guard<asio::io_context::executor_type> work_;
    Metrics& metrics_;
    std::unique_ptr<HttpClient> client_;
    std::unique_ptr<const OriginLink> link_;
    std::map<std::string, std::weak_ptr<CachedFile>> open_files_;  // by content id; the store's thread alone

    mutable std::mutex mutex_;  // of all that follows
    std::map<std::string, Entry, std::less<>> entries_;
    std::uint64_t uses_ = 0;
    std::size_t looking_ = 0;
    StoreUrl base_;
    std::map<std::string, StoreUrl> urls_;  // of the list
    FileStamp list_stamp_;
    std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<Store>> open_origin(OriginOptions options, Metrics& metrics) {
    Descriptor folder = mvw::server::open_folder(options.folder);
    if (!folder.ok()) return io_error(options.folder);
    auto store = std::make_unique<OriginStore>(std::move(options), metrics, std::move(folder));
    if (Result<void> r = store->start(); !r) return r.error();
    return std::unique_ptr<Store>(std::move(store));
}

}  // namespace mvw::server
