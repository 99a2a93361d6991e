#include "client/cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

#include "codec/container/crc32c.h"
#include "codec/container/toc.h"

namespace mvw::client {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kMagic = 0x4357564D;  // "MVWC"
constexpr std::string_view kEnding = ".chunks";

// Little-endian, like the protocol: magic, opened, then records of length and chunk.
Bytes head_of(const Opened& opened, const std::string& etag) {
    ByteWriter out;
    out.u32(kMagic);
    out.u32(opened.chunk_count);
    out.u64(opened.file_bytes);
    out.u64(opened.payload_bytes);
    out.u32(static_cast<std::uint32_t>(etag.size()));
    out.bytes(std::as_bytes(std::span(etag)));
    out.u32(static_cast<std::uint32_t>(opened.header.size()));
    out.bytes(opened.header);
    return out.take();
}

Bytes record_of(const Received& chunk) {
    ByteWriter out;
    out.u32(static_cast<std::uint32_t>(chunk.payload.size()));
    protocol::write_chunk_fields(out, {chunk.index, chunk.id, chunk.crc32c, chunk.error, {}});
    out.bytes(chunk.payload);
    return out.take();
}

bool read_record(ByteReader& in, Received& chunk) {
    const std::uint32_t length = in.u32();
    const protocol::Chunk fields = protocol::read_chunk_fields(in);
    const ByteSpan payload = in.bytes(length);
    chunk = {fields.index, fields.id, fields.crc32c, fields.error, Bytes(payload.begin(), payload.end())};
    return in.ok() && crc32c(payload) == chunk.crc32c;
}

std::optional<Stored> parse(ByteSpan bytes, const Limits& limits) {
    ByteReader in(bytes);
    Stored stored;
    if (in.u32() != kMagic) return std::nullopt;
    stored.chunk_count = in.u32();
    stored.file_bytes = in.u64();
    stored.payload_bytes = in.u64();
    const ByteSpan etag = in.bytes(in.u32());
    stored.etag.assign(reinterpret_cast<const char*>(etag.data()), etag.size());
    const ByteSpan header = in.bytes(in.u32());
    stored.header.assign(header.begin(), header.end());
    const Result<FileHeader> parsed = read_header(stored.header, limits);
    if (!in.ok() || !parsed) return std::nullopt;
    protocol::ChunkSet seen;
    for (Received chunk; in.remaining() > 0 && read_record(in, chunk);) {
        if (seen.contains(chunk.index) || !check_chunk_id(*parsed, chunk.id)) continue;
        seen.insert(chunk.index);
        stored.chunks.push_back(std::move(chunk));
    }
    std::sort(stored.chunks.begin(), stored.chunks.end(),
              [](const auto& a, const auto& b) { return a.index < b.index; });
    return stored;
}

Bytes read_whole(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const ByteSpan bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

bool write_whole(int file, ByteSpan bytes) {
    return ::write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
}

// The model's file: one for each content id, and for each way in, since HTTP knows no count of chunks before the index.
std::string name_of(const FileHeader& header, bool counted) {
    std::string hex;
    for (const std::uint8_t byte : header.content_id) hex += fmt::format("{:02x}", byte);
    return hex + (counted ? "" : "-http") + std::string(kEnding);
}

}  // namespace

ChunkCache::ChunkCache(Options options, std::string url) : options_(std::move(options)), url_(std::move(url)) {
    std::error_code ignored;
    fs::create_directories(options_.folder, ignored);
}

ChunkCache::~ChunkCache() {
    close();
}

std::optional<Stored> ChunkCache::load(const Limits& limits) {
    const Bytes name = read_whole(path(alias()));
    const std::string file(reinterpret_cast<const char*>(name.data()), name.size());
    if (!file.ends_with(kEnding) || file.find('/') != std::string::npos) return std::nullopt;
    const Bytes bytes = read_whole(path(file));
    std::optional<Stored> stored = parse(bytes, limits);
    if (!stored) return std::nullopt;
    kept_name_ = file;
    for (const Received& chunk : stored->chunks) kept_.insert(chunk.index);
    std::error_code ignored;
    fs::last_write_time(path(file), fs::file_time_type::clock::now(), ignored);  // used: goes last
    return stored;
}

void ChunkCache::begin(const Opened& opened, const std::string& etag) {
    close();
    const Result<FileHeader> header = read_header(opened.header);
    if (!header) return;
    const std::string name = name_of(*header, opened.chunk_count > 0);
    if (kept_name_ != name) {
        kept_.clear();
        kept_name_ = name;
    }
    make_room(name);
    std::ofstream(path(alias()), std::ios::binary) << name;
    file_ = ::open(path(name).c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
    struct stat s {};
    if (file_ < 0 || ::fstat(file_, &s) != 0) return close();
    file_bytes_ = static_cast<std::uint64_t>(s.st_size);
    if (file_bytes_ > 0) return;
    const Bytes head = head_of(opened, etag);
    file_bytes_ = head.size();
    if (!write_whole(file_, head)) close();
}

void ChunkCache::put(const Received& chunk) {
    if (file_ < 0 || kept_.contains(chunk.index)) return;
    const Bytes record = record_of(chunk);
    if (file_bytes_ + record.size() > options_.max_bytes) return;
    file_bytes_ += record.size();
    kept_.insert(chunk.index);
    if (!write_whole(file_, record)) close();
}

std::string ChunkCache::path(const std::string& name) const {
    return options_.folder + "/" + name;
}

std::string ChunkCache::alias() const {
    return fmt::format("{:016x}.url", XXH3_64bits(url_.data(), url_.size()));
}

// Removes what was used longest ago until half of the room is free for what is to come.
void ChunkCache::make_room(const std::string& keep) const {
    struct File {
        fs::file_time_type used;
        fs::path path;
        std::uint64_t bytes;
    };
    std::vector<File> files;
    std::uint64_t total = 0;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(options_.folder, error)) {
        std::error_code ignored;
        const std::uint64_t bytes = entry.file_size(ignored);
        if (ignored) continue;
        total += bytes;
        if (entry.path().filename() != keep) files.push_back({entry.last_write_time(ignored), entry.path(), bytes});
    }
    if (total <= options_.max_bytes) return;
    std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used < b.used; });
    for (const File& file : files) {
        if (total <= options_.max_bytes / 2) break;
        if (fs::remove(file.path, error)) total -= file.bytes;
    }
}

void ChunkCache::close() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
}

}  // namespace mvw::client
